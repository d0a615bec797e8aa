// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace evermap {

/// Why a scan's pose is not believed, or why the scan was not written into the map.
enum class RejectReason {
  kNone,            ///< it is believed
  kNoUsablePoint,   ///< no return of the scan is within the ranges used
  kTimeNotLater,    ///< its time is not after that of the scan before
  kTooFewBundles,   ///< the scan is nearly empty
  kTooFewMatches,   ///< it does not lie on the map
  kTooFewInliers,   ///< it lies on the map but does not fit
  kUnobservable,    ///< it fits, and would after a motion in the weakest direction, too
  kNoConvergence,   ///< the registration never came to rest
  kAmbiguous,       ///< it fits as well in another place nearby
  kFitsWorse,       ///< than the scans before
  kSeesLess,        ///< of the map than the scans before
  kTooFar,          ///< from the prediction
  kTurnedTooFar,    ///< from the prediction
  kOdometryJumps,   ///< farther than a vehicle can; the pose fits, but is not written
  kContradictsMap,  ///< its rays contradict too much of the map
};

/// The reason in words, one phrase without a stop; empty for kNone.
std::string_view to_string(RejectReason reason);

}  // namespace evermap
