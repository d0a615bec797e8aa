// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <evermap/bags/detail/messages.hpp>
#include <evermap/geometry/detail/trajectory.hpp>

namespace evermap {

/// The tree of frames that /tf and /tf_static tell, over the last minute.
class TransformBuffer {
 public:
  void add(const StampedTransform& transform, bool is_static);

  /// Forgets what moves, as when the clock was set back.
  void forget_motion();

  /// T_target_source at a time [s]; none when the frames are not connected, or not known at that time.
  std::optional<Pose> lookup(const std::string& target, const std::string& source, double time) const;
  /// Whether there is a way from `source` up or down to `target`, at any time.
  bool connects(const std::string& target, const std::string& source) const;

 private:
  struct Link {
    std::string parent;
    std::optional<Pose> T_parent_child;  ///< for ever
    Trajectory trajectory;               ///< T_parent_child over time
  };
  /// The frames from one up to its root, with T_parent_child of each step.
  struct Branch {
    std::vector<std::string> frames;
    std::vector<Pose> steps;
  };
  /// Up to where the tree is known at that time, or, without one, at any.
  Branch branch(const std::string& frame, std::optional<double> time) const;

  std::map<std::string, Link> links_;  ///< by the child
};

}  // namespace evermap
