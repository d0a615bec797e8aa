// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>

#include <evermap/bags/detail/chunked_bag.hpp>

namespace evermap {

/// A ROS 1 bag, version 2.0 (wiki.ros.org/Bags/Format/2.0). One without an index, as a recorder leaves it
/// that was killed, is read once to find its topics.
class Ros1Bag : public ChunkedBag {
 public:
  explicit Ros1Bag(const std::filesystem::path& path);

 private:
  /// Values by name, and what follows them. Views of a buffer.
  struct Record {
    std::map<std::string_view, std::string_view> header;
    std::string_view data;

    std::string_view text(std::string_view name) const;
    std::uint64_t number(std::string_view name, std::size_t size) const;
    unsigned op() const { return static_cast<unsigned>(number("op", 1)); }
  };

  std::optional<BagMessage> read_next() override;

  void read_index();
  /// The next record of the file; its data stay out when they are of a kind that nobody needs.
  Record read_record();
  /// The next record of the chunk in hand.
  Record read_chunk_record();
  Record parse_header(std::string_view header) const;
  std::optional<BagMessage> take(const Record& record);
  void add_connection(const Record& record);

  bool has_index_ = false;
  std::uint64_t begin_ = 0;  ///< [bytes] of the first chunk
  std::uint64_t end_ = 0;    ///< [bytes] where chunks end
  std::string buffer_;       ///< the record of the file in hand
  std::map<std::uint64_t, std::size_t> topic_of_connection_;
};

}  // namespace evermap
