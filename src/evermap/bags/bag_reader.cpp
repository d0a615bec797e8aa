// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <utility>

#include <evermap/bags/detail/bag_reader.hpp>
#include <evermap/bags/detail/decompress.hpp>
#include <evermap/bags/detail/mcap_bag.hpp>
#include <evermap/bags/detail/ros1_bag.hpp>
#include <evermap/bags/detail/sqlite_bag.hpp>
#include <evermap/bags/scan_bag.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/io/detail/file_order.hpp>

namespace evermap {
namespace {

struct Format {
  std::string_view extension;
  std::unique_ptr<BagReader> (*open)(const std::filesystem::path& path);
};
const Format* format_of(const std::filesystem::path& path);
std::unique_ptr<BagReader> open_part(const std::filesystem::path& path);

/// What is compressed as a whole is read from a copy.
class CompressedBag : public BagReader {
 public:
  explicit CompressedBag(const std::filesystem::path& path) : BagReader(path), copy_(path) {
    bag_ = format_of(path)->open(copy_.path());
    topics_ = bag_->topics();
  }

 private:
  std::optional<BagMessage> read_next() override {
    std::optional<BagMessage> message = bag_->next();
    if (!message && !bag_->damage().empty()) throw FileError(path(), bag_->damage());
    return message;
  }
  void on_select() override {
    std::vector<bool> selected(topics_.size());
    for (std::size_t i = 0; i < selected.size(); ++i) selected[i] = is_selected(i);
    bag_->select(std::move(selected));
  }

  UncompressedCopy copy_;
  std::unique_ptr<BagReader> bag_;
};

/// A bag in several files, read one after the other.
class SplitBag : public BagReader {
 public:
  SplitBag(const std::filesystem::path& folder, std::vector<std::filesystem::path> parts)
      : BagReader(folder), parts_(std::move(parts)) {
    for (const std::filesystem::path& part : parts_) {
      const std::unique_ptr<BagReader> bag = open_part(part);
      for (const BagTopic& topic : bag->topics())
        topics_[topic_of(topic.name, topic.type, topic.wire)].messages += topic.messages;
    }
  }

 private:
  std::optional<BagMessage> read_next() override {
    for (;;) {
      if (part_ == nullptr) {
        if (position_ == parts_.size()) return std::nullopt;
        open(parts_[position_++]);
      }
      if (std::optional<BagMessage> message = part_->next()) {
        message->topic = topic_of_part_[message->topic];
        return message;
      }
      if (!part_->damage().empty()) throw FileError(part_->path(), part_->damage());
      part_.reset();
    }
  }
  void on_select() override {
    if (part_ != nullptr) select_in_part();
  }

  void open(const std::filesystem::path& path) {
    part_ = open_part(path);
    topic_of_part_.clear();
    for (const BagTopic& topic : part_->topics())
      topic_of_part_.push_back(topic_of(topic.name, topic.type, topic.wire));
    select_in_part();
  }
  void select_in_part() {
    std::vector<bool> selected(topic_of_part_.size());
    for (std::size_t i = 0; i < selected.size(); ++i) selected[i] = is_selected(topic_of_part_[i]);
    part_->select(std::move(selected));
  }

  std::vector<std::filesystem::path> parts_;
  std::size_t position_ = 0;  ///< of the part that follows
  std::unique_ptr<BagReader> part_;
  std::vector<std::size_t> topic_of_part_;
};

template <class Bag>
std::unique_ptr<BagReader> open_as(const std::filesystem::path& path) {
  return std::make_unique<Bag>(path);
}

constexpr std::array<Format, 3> kFormats = {
    {{".bag", open_as<Ros1Bag>}, {".db3", open_as<SqliteBag>}, {".mcap", open_as<McapBag>}}};

bool is_compressed(const std::filesystem::path& path) {
  return path.extension() == ".zstd" || path.extension() == ".zst";
}

const Format* format_of(const std::filesystem::path& path) {
  const std::filesystem::path extension = is_compressed(path) ? path.stem().extension() : path.extension();
  const auto* format = std::find_if(kFormats.begin(), kFormats.end(),
                                    [&](const Format& known) { return known.extension == extension; });
  return format == kFormats.end() ? nullptr : format;
}

std::unique_ptr<BagReader> open_part(const std::filesystem::path& path) {
  return is_compressed(path) ? open_as<CompressedBag>(path) : format_of(path)->open(path);
}

std::vector<std::filesystem::path> parts_of(const std::filesystem::path& folder) {
  return files_in(folder, [](const std::filesystem::path& file) { return format_of(file) != nullptr; });
}

}  // namespace

void BagReader::select(std::vector<bool> topics) {
  selected_ = std::move(topics);
  on_select();
}

std::optional<BagMessage> BagReader::next() {
  if (!damage_.empty()) return std::nullopt;
  try {
    return read_next();
  } catch (const FileError& error) {
    // Named again by whoever reports it.
    damage_ = error.what();
    const std::string here = path_.string() + ": ";
    if (damage_.starts_with(here)) damage_.erase(0, here.size());
    return std::nullopt;
  }
}

void BagReader::count_messages() {
  while (const std::optional<BagMessage> message = next()) ++topics_[message->topic].messages;
  damage_.clear();  // which is met again
}

std::size_t BagReader::topic_of(std::string_view name, std::string_view type, Wire wire) {
  const auto found =
      std::find_if(topics_.begin(), topics_.end(), [&](const BagTopic& topic) { return topic.name == name; });
  if (found != topics_.end()) return static_cast<std::size_t>(found - topics_.begin());
  // package/msg/Type in ROS 2, package/Type in ROS 1.
  std::string short_type(type);
  constexpr std::string_view kMiddle = "/msg";
  if (const std::size_t at = short_type.find("/msg/"); at != std::string::npos)
    short_type.erase(at, kMiddle.size());
  topics_.push_back({std::string(name), std::move(short_type), wire});
  return topics_.size() - 1;
}

bool is_bag(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return !parts_of(path).empty();
  return format_of(path) != nullptr;
}

std::unique_ptr<BagReader> open_bag(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(path, ignored)) {
    if (format_of(path) == nullptr) throw FileError(path, "is no bag; known are .bag, .db3 and .mcap");
    return open_part(path);
  }
  std::vector<std::filesystem::path> parts = parts_of(path);
  if (parts.empty()) throw FileError(path, "holds no bag; known are .bag, .db3 and .mcap");
  if (parts.size() == 1) return open_part(parts.front());
  return std::make_unique<SplitBag>(path, std::move(parts));
}

}  // namespace evermap
