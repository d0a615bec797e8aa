// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/localization/detail/gate.hpp>
#include <evermap/localization/detail/registration.hpp>
#include <evermap/localization/detail/relocation.hpp>

namespace evermap {

/// All that governs localization.
struct LocalizationParameters {
  RegistrationParameters registration;
  GateParameters gate;
  RelocationParameters relocation;
};

}  // namespace evermap
