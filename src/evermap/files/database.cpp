// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <evermap/files/detail/database.hpp>

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

}  // namespace

Database::Database(std::filesystem::path path, Access access, std::string kind, std::string advice)
    : path_(std::move(path)), kind_(std::move(kind)), advice_(std::move(advice)) {
  std::string uri = "file:" + escaped(std::filesystem::absolute(path_).string());
  const bool is_changed = access == Access::kShare || access == Access::kWrite;
  uri += access == Access::kWrite ? "?mode=rwc" : is_changed ? "?mode=rw" : "?mode=ro";
  if (access == Access::kFrozen) uri += "&immutable=1";
  const int flags = (is_changed ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY) |
                    (access == Access::kWrite ? SQLITE_OPEN_CREATE : 0);
  sqlite3* opened = nullptr;
  const int error = ::sqlite3_open_v2(uri.c_str(), &opened, flags | SQLITE_OPEN_URI, nullptr);
  handle_.reset(opened);
  if (error != SQLITE_OK) fail();
  // What a stranger's file defines is not run.
  ::sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  ::sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  constexpr int kPatience = 10'000;  // [ms] for another process's transaction
  ::sqlite3_busy_timeout(opened, kPatience);
}

void Database::execute(const std::string& statements) {
  if (::sqlite3_exec(handle_.get(), statements.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

void Database::fail() const {
  const int error = ::sqlite3_errcode(handle_.get());
  const std::string reason = ::sqlite3_errmsg(handle_.get());
  const bool is_damaged = error == SQLITE_CORRUPT || error == SQLITE_NOTADB || error == SQLITE_ERROR ||
                          error == SQLITE_INTERRUPT || error == SQLITE_SCHEMA;
  throw FileError(path_,
                  is_damaged ? "cannot be read as a " + kind_ + ": " + reason + "; " + advice_ : reason);
}

Statement::Statement(Database& database, std::string_view sql) : database_(database) {
  sqlite3_stmt* prepared = nullptr;
  const int result =
      ::sqlite3_prepare_v2(database.handle(), sql.data(), static_cast<int>(sql.size()), &prepared, nullptr);
  statement_.reset(prepared);
  check(result);
}

void Statement::check(int result) const {
  if (result != SQLITE_OK) database_.fail();
}

Statement& Statement::bind(std::int64_t value) {
  check(::sqlite3_bind_int64(statement_.get(), ++bound_, value));
  return *this;
}

Statement& Statement::bind(double value) {
  check(::sqlite3_bind_double(statement_.get(), ++bound_, value));
  return *this;
}

Statement& Statement::bind(std::string_view text) {
  check(::sqlite3_bind_text(statement_.get(), ++bound_, text.data(), static_cast<int>(text.size()),
                            SQLITE_TRANSIENT));
  return *this;
}

Statement& Statement::bind_blob(std::string_view bytes) {
  check(::sqlite3_bind_blob64(statement_.get(), ++bound_, bytes.data(), bytes.size(), SQLITE_STATIC));
  return *this;
}

bool Statement::step() {
  const int result = ::sqlite3_step(statement_.get());
  if (result != SQLITE_ROW && result != SQLITE_DONE) database_.fail();
  return result == SQLITE_ROW;
}

void Statement::run() {
  step();
  check(::sqlite3_reset(statement_.get()));
  bound_ = 0;
}

std::string Statement::text(int column) const {
  const auto* text = reinterpret_cast<const char*>(::sqlite3_column_text(statement_.get(), column));
  return text == nullptr ? "" : text;
}

std::string_view Statement::blob(int column) const {
  const auto* data = static_cast<const char*>(::sqlite3_column_blob(statement_.get(), column));
  return {data == nullptr ? "" : data,
          static_cast<std::size_t>(::sqlite3_column_bytes(statement_.get(), column))};
}

Transaction::~Transaction() {
  if (is_open_) ::sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  database_.execute("COMMIT");
  is_open_ = false;
}

}  // namespace evermap
