// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <evermap/bags/detail/wire_reader.hpp>

namespace evermap {

struct BagTopic {
  std::string name;
  std::string type;  ///< such as sensor_msgs/PointCloud2, whichever ROS wrote it
  Wire wire = Wire::kRos1;
  std::uint64_t messages = 0;  ///< that the bag says it holds, or, if it has no index, that are there
};

struct BagMessage {
  std::size_t topic;       ///< in topics()
  double time;             ///< [s] since 1970, when it was recorded
  std::string_view bytes;  ///< until the next message is read
};

/// The messages of a bag in the order in which they were recorded, one at a time: memory is taken for the
/// largest chunk, not for the bag. Not thread safe.
class BagReader {
 public:
  virtual ~BagReader() = default;

  const std::filesystem::path& path() const { return path_; }
  const std::vector<BagTopic>& topics() const { return topics_; }
  /// From now on only messages of these topics are read; all by default.
  void select(std::vector<bool> topics);

  /// The next message; none at the end, and where the file is damaged.
  std::optional<BagMessage> next();
  /// What ended the bag before its end, with the place; empty as long as nothing did.
  const std::string& damage() const { return damage_; }

 protected:
  explicit BagReader(std::filesystem::path path) : path_(std::move(path)) {}

  /// next(), except that damage is thrown as FileError.
  virtual std::optional<BagMessage> read_next() = 0;
  virtual void on_select() {}
  bool is_selected(std::size_t topic) const { return selected_.empty() || selected_[topic]; }

  /// Reads everything once, to count the messages of each topic where no index tells.
  void count_messages();
  /// The topic of a name, made if there is none.
  std::size_t topic_of(std::string_view name, std::string_view type, Wire wire);
  std::vector<BagTopic> topics_;

 private:
  std::filesystem::path path_;
  std::vector<bool> selected_;
  std::string damage_;
};

/// Opens a bag, all parts of it when the path is a folder. Throws FileError when it cannot be read, is no
/// bag, or damaged such that nothing can be read of it.
std::unique_ptr<BagReader> open_bag(const std::filesystem::path& path);

}  // namespace evermap
