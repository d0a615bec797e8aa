// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace evermap {

/// The one exception of whatever reads or writes files: which file, where in it, what is wrong, what to do.
///
/// `what()` is one line: `path: at byte 123: message` (or `at line 7`, or without a place when the whole file
/// is meant). A text that comes from no file, such as a shipped scenario, has its name for a path.
class FileError : public std::runtime_error {
 public:
  enum class Unit { kNone, kByte, kLine };

  FileError(std::filesystem::path path, const std::string& message)
      : FileError(std::move(path), Unit::kNone, 0, message) {}
  FileError(std::filesystem::path path, Unit unit, std::uint64_t position, const std::string& message)
      : std::runtime_error(path.string() + ": " + place(unit, position) + message),
        path_(std::move(path)),
        unit_(unit),
        position_(position) {}

  static FileError at_byte(std::filesystem::path path, std::uint64_t offset, const std::string& message) {
    return {std::move(path), Unit::kByte, offset, message};
  }
  static FileError at_line(std::filesystem::path path, std::uint64_t line, const std::string& message) {
    return {std::move(path), Unit::kLine, line, message};
  }

  const std::filesystem::path& path() const { return path_; }
  Unit unit() const { return unit_; }
  std::uint64_t position() const { return position_; }  ///< byte offset from 0, or line number from 1

 private:
  static std::string place(Unit unit, std::uint64_t position) {
    if (unit == Unit::kNone) return "";
    return (unit == Unit::kByte ? "at byte " : "at line ") + std::to_string(position) + ": ";
  }

  std::filesystem::path path_;
  Unit unit_;
  std::uint64_t position_;
};

}  // namespace evermap
