// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/bags/detail/decompress.hpp>
#include <evermap/bags/detail/sqlite_bag.hpp>
#include <evermap/files/detail/input_file.hpp>

namespace evermap {

// Frozen: it is read where it lies, without locks, unless a recorder that was killed left its journal.
SqliteBag::SqliteBag(const std::filesystem::path& path)
    : BagReader(path),
      size_(InputStream(path).rest()),
      database_(path,
                std::filesystem::exists(path.string() + "-wal") ? Database::Access::kRead
                                                                : Database::Access::kFrozen,
                "bag of rosbag2", "copy the file again") {
  constexpr int kOften = 1000;
  ::sqlite3_progress_handler(database_.handle(), kOften, count_operations, this);
  Statement topics = prepare(
      "SELECT id, name, type, serialization_format, "
      "(SELECT COUNT(*) FROM messages WHERE topic_id = topics.id) FROM topics ORDER BY id");
  while (topics.step()) {
    if (topics.text(3) != "cdr") continue;
    const std::size_t topic = topic_of(topics.text(1), topics.text(2), Wire::kCdr);
    topics_[topic].messages += static_cast<std::uint64_t>(std::max<std::int64_t>(topics.integer(4), 0));
    topic_of_id_[topics.integer(0)] = topic;
    total_ += topics_[topic].messages;
  }
}

/// Pages that lead back to themselves would be read for ever.
int SqliteBag::count_operations(void* bag) {
  std::uint64_t& left = static_cast<SqliteBag*>(bag)->operations_left_;
  return left == 0 ? 1 : (--left, 0);
}

Statement SqliteBag::prepare(const std::string& query) {
  // A message takes more bytes than operations to find it; a small file may need some to be opened.
  operations_left_ = 100 + size_ / 250;
  return {database_, query};
}

std::optional<BagMessage> SqliteBag::read_next() {
  if (!messages_) {
    std::string ids;
    for (const auto& [id, topic] : topic_of_id_) {
      if (!is_selected(topic)) continue;
      if (!ids.empty()) ids += ',';
      ids += std::to_string(id);
    }
    // rosbag2 keeps an index of the times.
    messages_.emplace(prepare("SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN (" + ids +
                              ") ORDER BY timestamp, id"));
    done_ = 0;
  }
  if (!messages_->step()) return std::nullopt;
  if (++done_ > total_) throw FileError(path(), "its index is damaged; copy the file again");
  const auto topic = topic_of_id_.find(messages_->integer(0));
  const double time = 1e-9 * static_cast<double>(messages_->integer(1));
  std::string_view bytes = messages_->blob(2);
  if (is_zstd(bytes)) {  // no serialized message begins so
    const std::optional<std::string> fault =
        decompress("zstd", bytes, zstd_size(bytes).value_or(0), uncompressed_);
    if (fault)
      throw FileError(path(), "message " + std::to_string(done_) + " " + *fault + "; copy the file again");
    bytes = uncompressed_;
  }
  return BagMessage{topic->second, time, bytes};
}

}  // namespace evermap
