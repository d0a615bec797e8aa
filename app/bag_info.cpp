// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bag_info.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "progress_bar.hpp"
#include "report.hpp"
#include <evermap/bags/detail/bag_summary.hpp>

namespace evermap {
namespace {

std::string fields_of(const CloudHead& cloud) {
  std::string fields;
  for (const CloudField& field : cloud.fields)
    fields += fmt::format("{}{} {}", fields.empty() ? "" : ", ", field.name, name_of(field.type));
  return fields;
}

/// What tells where the sensor was: topics of poses, and the frames that /tf joins with it.
std::vector<std::string> references_of(const BagSummary& bag, const std::string& sensor) {
  std::vector<std::string> names;
  for (const std::string frame : {"odom", "map", "world"}) {
    const bool is_known = std::binary_search(bag.frames.begin(), bag.frames.end(), frame);
    if (is_known && frame != sensor && bag.transforms.connects(frame, sensor)) names.push_back(frame);
  }
  for (const TopicSummary& topic : bag.topics) {
    if (kind_of(topic.topic.type) == MessageKind::kPoses && topic.messages > 0)
      names.push_back(topic.topic.name);
  }
  return names;
}

bool is_usable(const TopicSummary& topic) { return topic.cloud.has_value(); }

void print_text(const std::filesystem::path& path, const BagSummary& bag) {
  fmt::print("bag      {}\nlasts    {:.1f} s, from {:.3f} s on\n", path.string(), bag.last - bag.first,
             bag.first);
  for (const TopicSummary& topic : bag.topics) {
    fmt::print("topic    {}  {}  {} messages", topic.topic.name, topic.topic.type, topic.messages);
    if (topic.rate() > 0) fmt::print(", {:.2f} Hz, longest gap {:.2f} s", topic.rate(), topic.longest_gap);
    fmt::print("\n");
    if (!topic.cloud) continue;
    fmt::print("         frame {}, {} x {} points", topic.cloud->frame, topic.cloud->height,
               topic.cloud->width);
    if (!topic.cloud->fields.empty()) fmt::print(": {}", fields_of(*topic.cloud));
    fmt::print("\n");
  }
  if (!bag.frames.empty()) {
    std::string frames;
    for (const std::string& frame : bag.frames) frames += " " + frame;
    fmt::print("frames  {}\n", frames);
  }
  const auto clouds = std::count_if(bag.topics.begin(), bag.topics.end(), is_usable);
  for (const TopicSummary& topic : bag.topics) {
    if (!is_usable(topic)) continue;
    const std::string choice = clouds > 1 ? " --topic " + topic.topic.name : "";
    const std::vector<std::string> references = references_of(bag, topic.cloud->frame);
    const std::string odometry = references.empty() ? "" : " --odometry " + references.front();
    fmt::print("use      evermap build {}{}{} -r 0.2 -o map.evm\n", path.string(), choice, odometry);
    for (const std::string& reference : references)
      fmt::print("         --odometry or --poses {}\n", reference);
  }
  if (clouds == 0) fmt::print("use      none: there are no point clouds that evermap reads\n");
}

void print_json(const std::filesystem::path& path, const BagSummary& bag) {
  Json topics = Json::array();
  for (const TopicSummary& topic : bag.topics) {
    Json json = {{"topic", topic.topic.name},
                 {"type", topic.topic.type},
                 {"messages", topic.messages},
                 {"first_s", topic.first},
                 {"last_s", topic.last},
                 {"rate_hz", topic.rate()},
                 {"longest_gap_s", topic.longest_gap}};
    if (topic.cloud) {
      json["frame"] = topic.cloud->frame;
      json["height"] = topic.cloud->height;
      json["width"] = topic.cloud->width;
      json["fields"] = fields_of(*topic.cloud);
      json["poses_from"] = references_of(bag, topic.cloud->frame);
    }
    topics.push_back(std::move(json));
  }
  fmt::print("{}", dump({{"bag", path.string()},
                         {"first_s", bag.first},
                         {"last_s", bag.last},
                         {"topics", topics},
                         {"frames", bag.frames},
                         {"damage", bag.damage}}));
}

}  // namespace

void print_bag_info(const std::filesystem::path& path, bool as_json) {
  std::unique_ptr<ProgressBar> bar;
  const BagSummary bag = summarize_bag(path, [&](std::uint64_t done, std::uint64_t total) {
    constexpr std::uint64_t kSeldom = 100;
    if (done % kSeldom != 0) return;
    if (!bar) bar = std::make_unique<ProgressBar>(total, "messages");
    bar->show(std::min(done, total));
  });
  bar.reset();
  if (!bag.damage.empty()) spdlog::warn("{}: {}", path.string(), bag.damage);
  as_json ? print_json(path, bag) : print_text(path, bag);
}

}  // namespace evermap
