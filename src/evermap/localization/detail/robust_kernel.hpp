// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace evermap {

/// Geman and McClure's kernel: what lies far off the map (a vehicle, a heap that grew) loses its say instead
/// of dragging the pose. `width` is the Mahalanobis distance at which a residual has a quarter of its weight.
struct RobustKernel {
  double width;

  double weight(double mahalanobis_squared) const {
    const double ratio = width * width / (width * width + mahalanobis_squared);
    return ratio * ratio;
  }
};

}  // namespace evermap
