// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <evermap/bags/detail/transform_buffer.hpp>

namespace evermap {

struct TopicSummary {
  BagTopic topic;
  std::uint64_t messages = 0;      ///< that were read
  double first = 0, last = 0;      ///< [s] when they were recorded
  double longest_gap = 0;          ///< [s]
  std::optional<CloudHead> cloud;  ///< of the first message of a topic of clouds

  /// [Hz] 0 for less than two messages.
  double rate() const;
};

struct BagSummary {
  std::vector<TopicSummary> topics;
  std::vector<std::string> frames;  ///< that /tf and /tf_static name, sorted
  TransformBuffer transforms;       ///< of these, those of the last minute
  double first = 0, last = 0;       ///< [s] of all messages
  std::string damage;               ///< what ended the bag before its end; empty when nothing did
};

/// Reads all of a bag, and tells `progress` how many of how many messages are read. Throws as open_bag()
/// does.
using BagProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;
BagSummary summarize_bag(const std::filesystem::path& path, const BagProgress& progress = {});

}  // namespace evermap
