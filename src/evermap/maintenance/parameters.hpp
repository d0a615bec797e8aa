// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <evermap/localization/parameters.hpp>
#include <evermap/scan/lidar_parameters.hpp>
#include <evermap/update/parameters.hpp>

namespace evermap {

/// How a map is protected from scans whose poses nobody vouches for.
struct RollbackParameters {
  int scans = 20;  ///< [scans] whose changes are undone when the robot was lost
};

/// All that governs evermap; `evermap config` prints each with its unit, range and default.
struct Parameters {
  LidarParameters lidar;
  UpdateParameters update;
  LocalizationParameters localization;
  RollbackParameters rollback;

  /// The rules of the published method.
  static Parameters paper() { return {{}, UpdateParameters::paper(), {}, {}}; }
};

}  // namespace evermap
