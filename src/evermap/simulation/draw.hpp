// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <random>

namespace evermap {

// Draws without std's distributions, which differ between libraries: a seed names the same trial everywhere.

template <class Any>
Any one_of(std::mt19937_64& random, std::initializer_list<Any> things) {
  return *(things.begin() + random() % things.size());
}

inline double uniform(std::mt19937_64& random, double from, double to) {
  return from + (to - from) * static_cast<double>(random() >> 11) * 0x1p-53;
}

}  // namespace evermap
