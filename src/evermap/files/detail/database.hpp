// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <sqlite3.h>
#include <string>
#include <string_view>

#include <evermap/files/file_error.hpp>

namespace evermap {

/// A file of SQLite. All that goes wrong throws FileError naming the file. Not thread safe.
class Database {
 public:
  enum class Access {
    kFrozen,  ///< of a file that nobody writes
    kRead,    ///< of a file that others may be writing; nothing beside it changes
    kShare,   ///< likewise, but what writers that are gone left beside it is put away
    kWrite,   ///< makes the file when there is none
  };
  /// `kind` says what the file should be, `advice` what to do when it is damaged.
  Database(std::filesystem::path path, Access access, std::string kind, std::string advice);

  const std::filesystem::path& path() const { return path_; }
  sqlite3* handle() const { return handle_.get(); }
  void execute(const std::string& statements);
  [[noreturn]] void fail() const;

 private:
  struct Close {
    void operator()(sqlite3* handle) const { ::sqlite3_close(handle); }
  };

  std::filesystem::path path_;
  std::string kind_;
  std::string advice_;
  std::unique_ptr<sqlite3, Close> handle_;
};

/// A prepared statement of a database, which must outlive it.
class Statement {
 public:
  Statement(Database& database, std::string_view sql);

  Statement& bind(std::int64_t value);
  Statement& bind(double value);
  Statement& bind(std::string_view text);
  Statement& bind_blob(std::string_view bytes);  ///< REQUIRES: `bytes` live until the statement is stepped

  /// The next row; false when there is none.
  bool step();
  /// Runs a statement that gives no rows, and makes it ready for other values.
  void run();

  std::int64_t integer(int column) const { return ::sqlite3_column_int64(statement_.get(), column); }
  double real(int column) const { return ::sqlite3_column_double(statement_.get(), column); }
  bool is_null(int column) const { return ::sqlite3_column_type(statement_.get(), column) == SQLITE_NULL; }
  std::string text(int column) const;
  std::string_view blob(int column) const;  ///< valid until the next step

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { ::sqlite3_finalize(statement); }
  };

  void check(int result) const;

  Database& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  int bound_ = 0;
};

/// Changes that happen together or not at all: undone unless commit() was called.
class Transaction {
 public:
  explicit Transaction(Database& database) : database_(database) { database_.execute("BEGIN IMMEDIATE"); }
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  /// Returns once the changes would survive a power cut.
  void commit();

 private:
  Database& database_;
  bool is_open_ = true;
};

}  // namespace evermap
