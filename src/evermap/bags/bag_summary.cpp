// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <set>

#include <evermap/bags/detail/bag_summary.hpp>

namespace evermap {

double TopicSummary::rate() const {
  return messages > 1 && last > first ? static_cast<double>(messages - 1) / (last - first) : 0;
}

BagSummary summarize_bag(const std::filesystem::path& path, const BagProgress& progress) {
  const std::unique_ptr<BagReader> bag = open_bag(path);
  BagSummary summary;
  std::uint64_t total = 0;
  for (const BagTopic& topic : bag->topics()) {
    summary.topics.emplace_back().topic = topic;
    total += topic.messages;
  }
  std::set<std::string> frames;
  std::uint64_t done = 0;
  while (const std::optional<BagMessage> message = bag->next()) {
    TopicSummary& topic = summary.topics[message->topic];
    if (done == 0) summary.first = message->time;
    summary.last = std::max(summary.last, message->time);
    if (topic.messages++ == 0) topic.first = topic.last = message->time;
    topic.longest_gap = std::max(topic.longest_gap, message->time - topic.last);
    topic.last = std::max(topic.last, message->time);
    if (is_cloud(topic.topic) && !topic.cloud)
      topic.cloud = read_cloud_head(topic.topic, message->bytes, bag->path());
    if (kind_of(topic.topic.type) == MessageKind::kTransforms) {
      for (const StampedTransform& transform : read_transforms(topic.topic, message->bytes)) {
        summary.transforms.add(transform, topic.topic.name.ends_with("tf_static"));
        frames.insert(transform.parent);
        frames.insert(transform.child);
      }
    }
    if (progress) progress(++done, total);
  }
  summary.frames.assign(frames.begin(), frames.end());
  summary.damage = bag->damage();
  return summary;
}

}  // namespace evermap
