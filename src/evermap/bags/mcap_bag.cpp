// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <zlib.h>

#include <evermap/bags/detail/mcap_bag.hpp>
#include <evermap/bags/detail/mcap_format.hpp>

namespace evermap {
namespace {

constexpr std::size_t kRecordHead = 9;  // [bytes] op and length

/// MCAP's own records are packed and little endian, with lengths of 32 bits, like messages of ROS 1.
WireReader reader_of(std::string_view content) { return {content, Wire::kRos1}; }

double seconds(std::uint64_t nanoseconds) { return 1e-9 * static_cast<double>(nanoseconds); }

}  // namespace

McapBag::McapBag(const std::filesystem::path& path) : ChunkedBag(path), size_(file_.rest()) {
  if (!begins_with(kMcapMagic)) throw FileError(path, "is no MCAP file; copy it again");
  if (!read_summary()) {
    go_to(kMcapMagic.size());
    count_messages();
  }
  go_to(kMcapMagic.size());
  is_at_end_ = false;
}

/// False when the file has none, or not all that is needed of it.
bool McapBag::read_summary() {
  constexpr std::size_t kFooterSize = kRecordHead + 8 + 8 + 4;  // [bytes]
  if (size_ < 2 * kMcapMagic.size() + kFooterSize) return false;
  file_.seek(size_ - kMcapMagic.size() - kFooterSize);
  const std::uint64_t footer_at = file_.position();
  std::string end;
  file_.append_to(end, file_.rest());
  if (!end.ends_with(kMcapMagic) || static_cast<unsigned char>(end.front()) != McapOp::kFooter) return false;
  const auto summary = reader_of(std::string_view(end).substr(kRecordHead)).number<std::uint64_t>();
  if (summary < kMcapMagic.size() || summary >= footer_at) return false;
  bool has_statistics = false;
  try {
    for (file_.seek(summary); file_.position() < footer_at;) {
      const Record record = read_record();
      take(record);
      if (record.op != McapOp::kStatistics) continue;
      WireReader statistics = reader_of(record.content);
      statistics.skip(1, 8 + 2 + 4 + 4 + 4 + 4 + 8 + 8);  // the whole file's
      constexpr std::size_t kEntry = 10;                  // [bytes] channel and number of messages
      for (auto left = statistics.number<std::uint32_t>() / kEntry; left > 0 && statistics.is_good();
           --left) {
        const auto channel = channels_.find(statistics.number<std::uint16_t>());
        const auto messages = statistics.number<std::uint64_t>();
        if (channel != channels_.end()) topics_[channel->second].messages += messages;
      }
      has_statistics = statistics.is_good();
    }
  } catch (const FileError&) {
    has_statistics = false;
  }
  if (has_statistics && !topics_.empty()) return true;
  for (BagTopic& topic : topics_) topic.messages = 0;
  return false;
}

std::optional<BagMessage> McapBag::read_next() {
  for (;;) {
    while (chunk_position_ < chunk_.size()) {
      if (std::optional<BagMessage> message = take(read_chunk_record())) return message;
    }
    if (is_at_end_) return std::nullopt;
    const Record record = read_record();
    is_at_end_ = record.op == McapOp::kDataEnd || record.op == McapOp::kFooter;
    if (record.op == McapOp::kChunk) {
      unpack(record.content);
    } else if (std::optional<BagMessage> message = take(record)) {
      return message;
    }
  }
}

McapBag::Record McapBag::read_record() {
  if (file_.rest() < kRecordHead) fail_at_end();
  std::string head;
  file_.append_to(head, kRecordHead);
  Record record{.op = static_cast<unsigned char>(head.front())};
  const auto size = reader_of(std::string_view(head).substr(1)).number<std::uint64_t>();
  if (size > file_.rest()) fail_at_end();
  const bool is_needed = record.op == McapOp::kSchema || record.op == McapOp::kChannel ||
                         record.op == McapOp::kMessage || record.op == McapOp::kChunk ||
                         record.op == McapOp::kStatistics;
  if (!is_needed) {
    file_.seek(file_.position() + size);
    return record;
  }
  buffer_.clear();
  file_.append_to(buffer_, size);
  record.content = buffer_;
  return record;
}

McapBag::Record McapBag::read_chunk_record() {
  const std::string_view rest = rest_of_chunk();
  WireReader head = reader_of(rest);
  Record record{.op = head.number<std::uint8_t>()};
  record.content = head.take(head.number<std::uint64_t>());
  if (!head.is_good()) fail("the chunk before ends inside a record; copy the file again");
  chunk_position_ += kRecordHead + record.content.size();
  return record;
}

void McapBag::unpack(std::string_view content) {
  WireReader chunk = reader_of(content);
  chunk.skip(2, 8);  // its first and its last time
  const auto size = chunk.number<std::uint64_t>();
  const auto checksum = chunk.number<std::uint32_t>();
  const std::string_view compression = chunk.text();
  const std::string_view compressed = chunk.take(chunk.number<std::uint64_t>());
  if (!chunk.is_good()) fail("the chunk before is damaged; copy the file again");
  open_chunk(compression, compressed, size);
  const auto* bytes = reinterpret_cast<const Bytef*>(chunk_.data());
  if (checksum != 0 && checksum != ::crc32_z(0, bytes, chunk_.size())) {
    chunk_.clear();
    fail("the chunk before has another checksum than it says; copy the file again");
  }
}

std::optional<BagMessage> McapBag::take(const Record& record) {
  WireReader content = reader_of(record.content);
  if (record.op == McapOp::kSchema) {
    const auto id = content.number<std::uint16_t>();
    schemas_[id] = content.text();
  }
  if (record.op == McapOp::kChannel) add_channel(record.content);
  if (record.op != McapOp::kMessage) return std::nullopt;
  const auto id = content.number<std::uint16_t>();
  content.skip(1, 4);  // its number
  const auto time = content.number<std::uint64_t>();
  content.skip(1, 8);  // when it was sent
  if (!content.is_good()) fail("a message before is damaged; copy the file again");
  const auto channel = channels_.find(id);
  if (channel == channels_.end()) {
    if (unreadable_.contains(id)) return std::nullopt;
    fail("a message before belongs to no topic; copy the file again");
  }
  if (!is_selected(channel->second)) return std::nullopt;
  constexpr std::size_t kHead = 2 + 4 + 8 + 8;  // [bytes]
  return BagMessage{channel->second, seconds(time), record.content.substr(kHead)};
}

void McapBag::add_channel(std::string_view content) {
  WireReader channel = reader_of(content);
  const auto id = channel.number<std::uint16_t>();
  const auto schema = channel.number<std::uint16_t>();
  const std::string_view name = channel.text();
  const std::string_view encoding = channel.text();
  if (!channel.is_good()) fail("a channel before is damaged; copy the file again");
  if (encoding != "ros1" && encoding != "cdr") {
    unreadable_.insert(id);
  } else {
    channels_[id] = topic_of(name, schemas_[schema], encoding == "cdr" ? Wire::kCdr : Wire::kRos1);
  }
}

}  // namespace evermap
