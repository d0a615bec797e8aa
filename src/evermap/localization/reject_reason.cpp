// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <evermap/localization/reject_reason.hpp>

namespace evermap {

std::string_view to_string(RejectReason reason) {
  switch (reason) {
    case RejectReason::kNone:
      break;
    case RejectReason::kNoUsablePoint:
      return "has no usable point";
    case RejectReason::kTimeNotLater:
      return "is not later than the scan before";
    case RejectReason::kTooFewBundles:
      return "has too few points";
    case RejectReason::kTooFewMatches:
      return "lies off the map";
    case RejectReason::kTooFewInliers:
      return "does not fit the map";
    case RejectReason::kUnobservable:
      return "would fit as well after a motion in one direction";
    case RejectReason::kNoConvergence:
      return "does not come to rest";
    case RejectReason::kAmbiguous:
      return "fits as well in another place";
    case RejectReason::kFitsWorse:
      return "fits worse than before";
    case RejectReason::kSeesLess:
      return "sees less of the map than before";
    case RejectReason::kTooFar:
      return "is too far from the prediction";
    case RejectReason::kTurnedTooFar:
      return "is turned too far from the prediction";
    case RejectReason::kOdometryJumps:
      return "follows a jump of the odometry";
    case RejectReason::kContradictsMap:
      return "contradicts too much of the map";
  }
  return {};
}

}  // namespace evermap
