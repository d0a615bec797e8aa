// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <memory>
#include <optional>

#include <Eigen/Core>

#include <evermap/simulation/scene.hpp>

namespace evermap {

/// Finds where rays meet the surfaces of a scene.
///
/// Embree finds the triangle in single precision, around the scene's middle to stay precise in far-away
/// frames; the range is then computed from the triangle's plane in double precision. Thread safe after
/// construction.
class RayCaster {
 public:
  struct Hit {
    double range;   ///< [m]
    double cosine;  ///< [0, 1] of the angle of incidence
    int object;     ///< id of the solid
  };

  /// Copies what it needs of the scene. Throws std::runtime_error when Embree cannot take it.
  explicit RayCaster(const Scene& scene);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// The first surface along a ray that is not farther than about `limit` [m].
  /// REQUIRES: `direction` has length 1.
  std::optional<Hit> first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                               double limit = std::numeric_limits<double>::infinity()) const;

 private:
  class Tree;
  std::unique_ptr<const Tree> tree_;
};

}  // namespace evermap
