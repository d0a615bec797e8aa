// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include <evermap/bags/detail/decompress.hpp>
#include <evermap/bags/detail/sqlite_bag.hpp>
#include <evermap/files/detail/input_file.hpp>

namespace evermap {
namespace {

/// A path as a part of a URI.
std::string escaped(const std::string& path) {
  std::string uri;
  for (const char c : path) {
    if (c == '%' || c == '?' || c == '#') {
      uri += c == '%' ? "%25" : c == '?' ? "%3f" : "%23";
    } else {
      uri += c;
    }
  }
  return uri;
}

std::string text_of(sqlite3_stmt* statement, int column) {
  const auto* text = reinterpret_cast<const char*>(::sqlite3_column_text(statement, column));
  return text == nullptr ? "" : text;
}

}  // namespace

SqliteBag::SqliteBag(const std::filesystem::path& path) : BagReader(path) {
  size_ = InputStream(path).rest();
  sqlite3* opened = nullptr;
  // Immutable: it is read where it lies, without locks, unless a recorder that was killed left its journal.
  const std::string uri = "file:" + escaped(std::filesystem::absolute(path).string()) + "?mode=ro" +
                          (std::filesystem::exists(path.string() + "-wal") ? "" : "&immutable=1");
  const int error = ::sqlite3_open_v2(uri.c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
  database_.reset(opened);
  if (error != SQLITE_OK) fail();
  // What a stranger's file defines is not run.
  ::sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  ::sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  constexpr int kOften = 1000;
  ::sqlite3_progress_handler(opened, kOften, count_operations, this);
  const Statement topics = prepare(
      "SELECT id, name, type, serialization_format, "
      "(SELECT COUNT(*) FROM messages WHERE topic_id = topics.id) FROM topics ORDER BY id");
  while (step(topics)) {
    if (text_of(topics.get(), 3) != "cdr") continue;
    const std::size_t topic = topic_of(text_of(topics.get(), 1), text_of(topics.get(), 2), Wire::kCdr);
    topics_[topic].messages +=
        static_cast<std::uint64_t>(std::max<sqlite3_int64>(::sqlite3_column_int64(topics.get(), 4), 0));
    topic_of_id_[::sqlite3_column_int64(topics.get(), 0)] = topic;
    total_ += topics_[topic].messages;
  }
}

void SqliteBag::fail() const {
  throw FileError(path(), std::string("cannot be read as a bag of rosbag2: ") +
                              ::sqlite3_errmsg(database_.get()) + "; copy the file again");
}

/// Pages that lead back to themselves would be read for ever.
int SqliteBag::count_operations(void* bag) {
  std::uint64_t& left = static_cast<SqliteBag*>(bag)->operations_left_;
  return left == 0 ? 1 : (--left, 0);
}

SqliteBag::Statement SqliteBag::prepare(const std::string& query) {
  // A message takes more bytes than operations to find it; a small file may need some to be opened.
  operations_left_ = 100 + size_ / 250;
  sqlite3_stmt* prepared = nullptr;
  const int error = ::sqlite3_prepare_v2(database_.get(), query.c_str(), -1, &prepared, nullptr);
  Statement statement(prepared);
  if (error != SQLITE_OK) fail();
  return statement;
}

bool SqliteBag::step(const Statement& statement) const {
  const int result = ::sqlite3_step(statement.get());
  if (result != SQLITE_ROW && result != SQLITE_DONE) fail();
  return result == SQLITE_ROW;
}

std::optional<BagMessage> SqliteBag::read_next() {
  if (messages_ == nullptr) {
    std::string ids;
    for (const auto& [id, topic] : topic_of_id_) {
      if (!is_selected(topic)) continue;
      if (!ids.empty()) ids += ',';
      ids += std::to_string(id);
    }
    // rosbag2 keeps an index of the times.
    messages_ = prepare("SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN (" + ids +
                        ") ORDER BY timestamp, id");
    done_ = 0;
  }
  if (!step(messages_)) return std::nullopt;
  if (++done_ > total_) throw FileError(path(), "its index is damaged; copy the file again");
  const auto topic = topic_of_id_.find(::sqlite3_column_int64(messages_.get(), 0));
  const double time = 1e-9 * static_cast<double>(::sqlite3_column_int64(messages_.get(), 1));
  const auto* data = static_cast<const char*>(::sqlite3_column_blob(messages_.get(), 2));
  std::string_view bytes(data == nullptr ? "" : data,
                         static_cast<std::size_t>(::sqlite3_column_bytes(messages_.get(), 2)));
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
