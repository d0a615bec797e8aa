// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/bags/detail/transform_buffer.hpp>

namespace evermap {

void TransformBuffer::add(const StampedTransform& transform, bool is_static) {
  constexpr double kMemory = 60;  // [s]
  if (transform.child.empty() || transform.child == transform.parent) return;
  Link& link = links_[transform.child];
  if (link.parent != transform.parent) link = Link{transform.parent, {}, {}};
  if (is_static) {
    link.T_parent_child = transform.T_parent_child;
  } else {
    link.trajectory.add(transform.time, transform.T_parent_child);
    link.trajectory.forget_before(transform.time - kMemory);
  }
}

void TransformBuffer::forget_motion() {
  for (auto& [child, link] : links_) link.trajectory = {};
}

TransformBuffer::Branch TransformBuffer::branch(const std::string& frame, std::optional<double> time) const {
  Branch branch{{frame}, {}};
  while (branch.frames.size() <= links_.size()) {  // a loop of frames is longer
    const auto link = links_.find(branch.frames.back());
    if (link == links_.end()) break;
    std::optional<Pose> step = link->second.T_parent_child;
    if (!step) step = time ? link->second.trajectory.at(*time) : Pose{};
    if (!step) break;
    branch.frames.push_back(link->second.parent);
    branch.steps.push_back(*step);
  }
  return branch;
}

std::optional<Pose> TransformBuffer::lookup(const std::string& target, const std::string& source,
                                            double time) const {
  const Branch up = branch(source, time);
  const Branch down = branch(target, time);
  for (std::size_t i = 0; i < up.frames.size(); ++i) {
    const auto meeting = std::find(down.frames.begin(), down.frames.end(), up.frames[i]);
    if (meeting == down.frames.end()) continue;
    Pose T_meeting_source;
    for (std::size_t step = 0; step < i; ++step) T_meeting_source = up.steps[step] * T_meeting_source;
    Pose T_meeting_target;
    for (auto step = down.steps.begin(); step != down.steps.begin() + (meeting - down.frames.begin()); ++step)
      T_meeting_target = *step * T_meeting_target;
    return T_meeting_target.inverse() * T_meeting_source;
  }
  return std::nullopt;
}

bool TransformBuffer::connects(const std::string& target, const std::string& source) const {
  const Branch up = branch(source, std::nullopt);
  const Branch down = branch(target, std::nullopt);
  return up.frames.back() == down.frames.back();
}

}  // namespace evermap
