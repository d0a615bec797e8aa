// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>

#include <evermap/bags/detail/bag_reader.hpp>
#include <evermap/files/detail/database.hpp>

namespace evermap {

/// A file of rosbag2 in SQLite, whose messages may each be compressed by Zstandard.
class SqliteBag : public BagReader {
 public:
  explicit SqliteBag(const std::filesystem::path& path);

 private:
  std::optional<BagMessage> read_next() override;
  void on_select() override { messages_.reset(); }

  Statement prepare(const std::string& query);
  /// Called every thousand operations; stops the statement when it has run for more than any good file needs.
  static int count_operations(void* bag);

  std::uint64_t size_;  ///< [bytes]
  Database database_;
  std::map<std::int64_t, std::size_t> topic_of_id_;
  std::optional<Statement> messages_;
  std::uint64_t total_ = 0;  ///< messages
  std::uint64_t done_ = 0;
  std::uint64_t operations_left_ = 0;  ///< [thousands]
  std::string uncompressed_;
};

}  // namespace evermap
