// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <evermap/files/file_error.hpp>

namespace evermap {

/// The numbers that a value may be, ends included. The widest reach as far as coordinates of a country do.
struct Limits {
  double least;
  double most;

  static Limits any() { return {-1e7, 1e7}; }
  static Limits not_negative() { return {0, 1e7}; }
  static Limits positive() { return {1e-6, 1e7}; }
};

class YamlMap;

/// A value of a YAML text that knows its key and its line. What a caller asks for and it is not, is a
/// FileError naming both. Copies share the text. Thread safe.
class YamlValue {
 public:
  /// The whole of a file, or of a text that is called `source` in errors. Throws FileError when the file
  /// cannot be read, or it is no YAML, or more than anybody writes (a million values, 64 levels).
  static YamlValue read(const std::filesystem::path& path);
  static YamlValue parse(const std::filesystem::path& source, const std::string& text);

  const std::string& key() const;
  int line() const;         ///< from 1
  bool is_nothing() const;  ///< nothing, `~` or `null` follows the key, or the text is empty
  bool is_list() const;
  bool is_map() const;
  [[noreturn]] void fail(const std::string& message) const;

  double number(const Limits& limits) const;
  int whole(int least, int most) const;
  std::uint64_t natural() const;
  bool truth() const;
  std::string text() const;
  std::vector<YamlValue> list() const;
  std::vector<double> numbers(std::size_t least_count, std::size_t most_count, const Limits& limits) const;
  Eigen::Vector2d vector2(const Limits& limits) const;
  Eigen::Vector3d vector3(const Limits& limits) const;
  /// One of `names`, given as (value, name).
  template <class Value, class Names>
  Value one_of(const Names& names) const {
    std::string wanted = "one of";
    for (const auto& [value, name] : names) {
      if (is_word(name)) return value;
      wanted += ' ';
      wanted += name;
    }
    fail_wanted(wanted);
  }
  YamlMap map() const;

 private:
  friend class YamlMap;
  struct Node;
  struct Text;
  YamlValue(std::shared_ptr<const Text> text, const Node& node) : text_(std::move(text)), node_(&node) {}

  bool is_word(std::string_view word) const;
  [[noreturn]] void fail_wanted(const std::string& wanted) const;

  std::shared_ptr<const Text> text_;  ///< keeps `node_` alive
  const Node* node_;
};

/// Values by key. A key that nobody asked for is a mistake in the text. Remembers what was asked for: not
/// thread safe.
class YamlMap {
 public:
  /// Nothing counts as a map without values. Throws FileError when `value` is anything else than a map, or a
  /// key stands twice.
  explicit YamlMap(const YamlValue& value);

  int line() const { return whole_.line(); }
  [[noreturn]] void fail(const std::string& message) const { whole_.fail(message); }

  /// None, too, when nothing follows the key.
  std::optional<YamlValue> find(const std::string& key) const;
  /// Throws FileError when there is none.
  YamlValue get(const std::string& key) const;
  double number(const std::string& key, const Limits& limits, std::optional<double> otherwise = {}) const;
  /// The map that follows the key; one without values when the key is not there.
  YamlMap section(const std::string& key) const;

  /// These values, except where `overrides` has others.
  YamlMap overridden(const YamlMap& overrides) const;
  /// Throws FileError at the first key that was not asked for. `hint` says where to find those that there
  /// are; without it, the error lists them.
  void refuse_unknown(std::string_view hint = {}) const;

  const std::vector<YamlValue>& values() const { return values_; }

 private:
  YamlMap(YamlValue whole, std::vector<YamlValue> values)
      : whole_(std::move(whole)), values_(std::move(values)) {}

  YamlValue whole_;
  std::vector<YamlValue> values_;
  mutable std::set<std::string> asked_;
};

}  // namespace evermap
