// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace evermap {

/// The one exception of the io layer: which file, where in it, what is wrong and what to do.
///
/// `what()` is one line: `path: at byte 123: message` (or `at line 7`, or without a place when the whole file
/// is meant).
class IoError : public std::runtime_error {
 public:
  enum class Unit { kNone, kByte, kLine };

  IoError(std::filesystem::path path, const std::string& message)
      : IoError(std::move(path), Unit::kNone, 0, message) {}
  IoError(std::filesystem::path path, Unit unit, std::uint64_t position, const std::string& message)
      : std::runtime_error(path.string() + ": " + place(unit, position) + message),
        path_(std::move(path)),
        unit_(unit),
        position_(position) {}

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
