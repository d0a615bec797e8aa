// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <yaml-cpp/yaml.h>

#include <evermap/simulation/scenario.hpp>

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

/// A value of a scenario's text that knows its key and place. What a caller asks for and it is not, is a
/// ScenarioError naming the line.
class YamlValue {
 public:
  YamlValue(std::string source, std::string key, const YAML::Node& node, int line)
      : source_(std::move(source)), key_(std::move(key)), node_(node), line_(line) {}
  /// The whole of a text. Throws ScenarioError when it is no YAML.
  static YamlValue parse(const std::string& source, const std::string& text);

  const std::string& key() const { return key_; }
  int line() const { return line_; }
  bool is_list() const { return node_.IsSequence(); }
  bool is_map() const { return node_.IsMap(); }
  [[noreturn]] void fail(const std::string& message) const { throw ScenarioError(source_, line_, message); }

  double number(const Limits& limits) const;
  int whole(int least, int most) const;
  std::uint64_t natural() const;
  bool truth() const;
  std::string text() const;
  std::vector<YamlValue> list() const;
  std::vector<double> numbers(std::size_t least_count, std::size_t most_count, const Limits& limits) const;
  Eigen::Vector2d vector2(const Limits& limits) const;
  Eigen::Vector3d vector3(const Limits& limits) const;
  YamlMap map() const;

 private:
  friend class YamlMap;
  [[noreturn]] void fail_wanted(const std::string& wanted) const;

  std::string source_;
  std::string key_;
  YAML::Node node_;
  int line_;
};

/// Values by key. A key that nobody asked for is a mistake in the text.
class YamlMap {
 public:
  /// Throws ScenarioError when `value` is no map or a key stands twice.
  explicit YamlMap(const YamlValue& value);

  int line() const { return whole_.line(); }
  [[noreturn]] void fail(const std::string& message) const { whole_.fail(message); }

  /// None, too, when nothing follows the key.
  std::optional<YamlValue> find(const std::string& key) const;
  /// Throws ScenarioError when there is none.
  YamlValue get(const std::string& key) const;
  double number(const std::string& key, const Limits& limits, std::optional<double> otherwise = {}) const;

  /// These values, except where `overrides` has others.
  YamlMap overridden(const YamlMap& overrides) const;
  /// Throws ScenarioError for the first key that was not asked for.
  void refuse_unknown() const;

  const std::vector<YamlValue>& values() const { return values_; }

 private:
  YamlValue whole_;
  std::vector<YamlValue> values_;
  mutable std::set<std::string> asked_;
};

}  // namespace evermap
