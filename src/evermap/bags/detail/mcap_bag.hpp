// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>

#include <evermap/bags/detail/chunked_bag.hpp>

namespace evermap {

/// An MCAP file of ROS 1 or ROS 2 messages (mcap.dev/spec). One without a summary, as a recorder leaves it
/// that was killed, is read once to find its topics.
class McapBag : public ChunkedBag {
 public:
  explicit McapBag(const std::filesystem::path& path);

 private:
  struct Record {
    unsigned op = 0;
    std::string_view content = {};
  };

  std::optional<BagMessage> read_next() override;

  bool read_summary();
  /// The next record of the file, the content only of kinds that are needed.
  Record read_record();
  /// The next record of the chunk in hand.
  Record read_chunk_record();
  void unpack(std::string_view content);
  std::optional<BagMessage> take(const Record& record);
  void add_channel(std::string_view content);

  std::uint64_t size_;  ///< [bytes]
  bool is_at_end_ = false;
  std::string buffer_;                             ///< the record of the file in hand
  std::map<std::uint16_t, std::string> schemas_;   ///< names of types
  std::map<std::uint16_t, std::size_t> channels_;  ///< topics; of those that can be read
  std::set<std::uint16_t> unreadable_;             ///< channels of other encodings
};

}  // namespace evermap
