// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/bags/detail/ros1_bag.hpp>
#include <evermap/files/detail/record_layout.hpp>

namespace evermap {
namespace {

constexpr std::string_view kRos1Magic = "#ROSBAG V2.0\n";
constexpr std::uint64_t kGreatestHeader = std::uint64_t{1} << 24;  // [bytes]

struct Ros1Op {
  enum : unsigned {
    kMessage = 2,
    kBagHeader = 3,
    kIndexData = 4,
    kChunk = 5,
    kChunkInfo = 6,
    kConnection = 7,
  };
};

std::uint64_t little(std::string_view bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

constexpr std::size_t kLength = 4;  // [bytes] of a length

/// Cuts a length and as many bytes off the front of `rest`.
std::optional<std::string_view> take_block(std::string_view& rest) {
  if (rest.size() < kLength) return std::nullopt;
  const std::uint64_t size = little(rest.substr(0, kLength));
  if (size > rest.size() - kLength) return std::nullopt;
  const std::string_view block = rest.substr(kLength, size);
  rest.remove_prefix(kLength + size);
  return block;
}

}  // namespace

std::string_view Ros1Bag::Record::text(std::string_view name) const {
  const auto found = header.find(name);
  return found == header.end() ? std::string_view() : found->second;
}

/// 0 for what is not there or has another size.
std::uint64_t Ros1Bag::Record::number(std::string_view name, std::size_t size) const {
  const std::string_view bytes = text(name);
  return bytes.size() == size ? little(bytes) : 0;
}

Ros1Bag::Ros1Bag(const std::filesystem::path& path) : ChunkedBag(path), end_(file_.rest()) {
  if (!begins_with(kRos1Magic))
    throw FileError(path, "is no ROS 1 bag of version 2.0 (rosbag fix makes one of older ones)");
  const Record header = read_record();
  if (header.op() != Ros1Op::kBagHeader) fail("has no bag header; copy the file again");
  begin_ = file_.position();
  const std::uint64_t index = header.number("index_pos", 8);
  has_index_ = index >= begin_ && index <= end_;
  if (has_index_) {
    file_.seek(index);
    read_index();
    end_ = index;
  }
  if (topics_.empty() && begin_ < end_) {
    has_index_ = false;
    go_to(begin_);
    count_messages();
  }
  go_to(begin_);
}

void Ros1Bag::read_index() {
  while (file_.rest() > 0) {
    const Record record = read_record();
    if (record.op() == Ros1Op::kConnection) add_connection(record);
    if (record.op() != Ros1Op::kChunkInfo) continue;
    constexpr std::size_t kEntry = 8;  // [bytes] connection and number of messages
    for (std::string_view rest = record.data; rest.size() >= kEntry; rest.remove_prefix(kEntry)) {
      const auto topic = topic_of_connection_.find(little(rest.substr(0, 4)));
      if (topic != topic_of_connection_.end()) topics_[topic->second].messages += little(rest.substr(4, 4));
    }
  }
}

std::optional<BagMessage> Ros1Bag::read_next() {
  for (;;) {
    while (chunk_position_ < chunk_.size()) {
      if (std::optional<BagMessage> message = take(read_chunk_record())) return message;
    }
    if (file_.position() >= end_) {
      if (!has_index_) fail("has no index; its recording was cut off");
      return std::nullopt;
    }
    const Record record = read_record();
    if (record.op() == Ros1Op::kChunk) {
      open_chunk(record.text("compression"), record.data, record.number("size", 4));
    } else if (std::optional<BagMessage> message = take(record)) {
      return message;
    }
  }
}

Ros1Bag::Record Ros1Bag::read_record() {
  const auto length = [&] {
    std::string bytes;
    if (file_.rest() < kLength) fail_at_end();
    file_.append_to(bytes, kLength);
    return little(bytes);
  };
  const std::uint64_t header_size = length();
  if (header_size > kGreatestHeader) fail("a record's header is damaged; copy the file again");
  if (header_size > file_.rest()) fail_at_end();
  buffer_.clear();
  file_.append_to(buffer_, header_size);
  const unsigned op = parse_header(buffer_).op();
  const std::uint64_t data_size = length();
  if (data_size > file_.rest()) fail_at_end();
  if (op == Ros1Op::kIndexData || op == Ros1Op::kBagHeader) {
    file_.seek(file_.position() + data_size);
  } else {
    file_.append_to(buffer_, data_size);
  }
  const std::string_view bytes = buffer_;
  Record record = parse_header(bytes.substr(0, header_size));
  record.data = bytes.substr(header_size);
  return record;
}

Ros1Bag::Record Ros1Bag::read_chunk_record() {
  std::string_view rest = rest_of_chunk();
  const std::optional<std::string_view> header = take_block(rest);
  const std::optional<std::string_view> data = take_block(rest);
  if (!header || !data) fail("the chunk before ends inside a record; copy the file again");
  chunk_position_ = chunk_.size() - rest.size();
  Record record = parse_header(*header);
  record.data = *data;
  return record;
}

Ros1Bag::Record Ros1Bag::parse_header(std::string_view header) const {
  Record record;
  while (!header.empty()) {
    const std::optional<std::string_view> field = take_block(header);
    const std::size_t equals = field ? field->find('=') : std::string_view::npos;
    if (equals == std::string_view::npos) fail("a record's header is damaged; copy the file again");
    record.header.emplace(field->substr(0, equals), field->substr(equals + 1));
  }
  return record;
}

std::optional<BagMessage> Ros1Bag::take(const Record& record) {
  if (record.op() == Ros1Op::kConnection) add_connection(record);
  if (record.op() != Ros1Op::kMessage) return std::nullopt;
  const auto topic = topic_of_connection_.find(record.number("conn", 4));
  if (topic == topic_of_connection_.end()) fail("a message before belongs to no topic; copy the file again");
  if (!is_selected(topic->second)) return std::nullopt;
  const std::uint64_t time = record.number("time", 8);  // seconds below, nanoseconds above
  return BagMessage{topic->second,
                    static_cast<double>(time & 0xFFFFFFFF) + 1e-9 * static_cast<double>(time >> 32),
                    record.data};
}

void Ros1Bag::add_connection(const Record& record) {
  const Record connection = parse_header(record.data);
  topic_of_connection_.emplace(record.number("conn", 4),
                               topic_of(record.text("topic"), connection.text("type"), Wire::kRos1));
}

}  // namespace evermap
