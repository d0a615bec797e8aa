// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <evermap/geometry/pose.hpp>
#include <evermap/scan/detail/labelled_box.hpp>
#include <evermap/scan/scan.hpp>

namespace evermap {

/// What a point of a labelled scan belongs to.
enum class PointClass {
  kStatic,
  kParked,
  kMoving,
  kExcluded,  ///< nearer than 2.5 m (the vehicle itself), in an uncertain box, or at a mover's wheels
};

/// The class of each point. Boxes are grown by 0.1 m; the lowest 0.15 m of a moving box is excluded, since
/// the ground there is static and the labels do not separate it.
std::vector<PointClass> classify(const Scan& scan, const std::vector<LabelledBox>& boxes);

/// How many raw points a map still claims, as in the public dynamic-map benchmarks. Points that should be
/// kept and that should be removed are counted apart.
struct DriveScore {
  static constexpr double kPoseSigma = 0.05;    ///< [m] how well a raw point's place is known
  static constexpr std::size_t kLastScans = 5;  ///< whose movers are still where the map shows them

  struct Fraction {
    std::size_t points = 0;
    std::size_t claimed = 0;

    double value() const { return static_cast<double>(claimed) / static_cast<double>(points); }
  };
  Fraction all_static;   ///< outside every box, whether or not the labels reach there
  Fraction seen_static;  ///< of these, the ones in the labelled field of view
  Fraction parked;
  Fraction moving;

  double removed() const { return 1 - moving.value(); }  ///< fraction of the movers' points that is gone
  double associated_accuracy() const;                    ///< AA of static kept and moving removed
  double harmonic_accuracy() const;                      ///< HA of the same
};

/// Whether a map claims surface at a point [m] of the map frame.
using Claim = std::function<bool(const Eigen::Vector3d& p_map)>;

/// Adds the points of one scan. Of the last scans of a run (`is_last`) the movers' points are not counted:
/// they are still where the map shows them.
void add_to_score(DriveScore& score, const Scan& scan, const Pose& T_map_sensor,
                  const std::vector<LabelledBox>& boxes, bool is_last, const Claim& claim);

}  // namespace evermap
