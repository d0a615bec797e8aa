// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <vector>

namespace evermap {

/// The standard deviation of a normal distribution over the median of how far its values are off.
inline constexpr double kMedianToSigma = 1.4826;

/// What is usual: the median of the last values.
class RunningMedian {
 public:
  /// `memory`: how many values it is taken over.
  explicit RunningMedian(std::size_t memory) : memory_(memory) {}

  /// Whether there are enough values for a median to mean anything.
  bool is_known() const { return values_.size() >= 5; }
  /// REQUIRES: is_known().
  double value() const {
    std::vector<double> sorted(values_.begin(), values_.end());
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    return *middle;
  }

  void push(double value) {
    values_.push_back(value);
    if (values_.size() > memory_) values_.pop_front();
  }

 private:
  std::size_t memory_;
  std::deque<double> values_;
};

}  // namespace evermap
