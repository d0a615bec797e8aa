// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <utility>

#include <evermap/simulation/yaml_value.hpp>

namespace evermap {
namespace {

int line_of(const YAML::Mark& mark) { return mark.line + 1; }

/// Digits as a person would write them.
std::string plain(double number) {
  std::string digits = std::to_string(number);
  digits.erase(digits.find_last_not_of('0') + 1);
  if (digits.back() == '.') digits.pop_back();
  return digits;
}

std::string describe(const Limits& limits) {
  if (limits.most >= Limits::any().most) {
    if (limits.least < 0) return "a number";
    return limits.least > 0 ? "a number above 0" : "a number of at least 0";
  }
  return "a number from " + plain(limits.least) + " to " + plain(limits.most);
}

}  // namespace

YamlValue YamlValue::parse(const std::string& source, const std::string& text) {
  try {
    return {source, "the file", YAML::Load(text), 1};
  } catch (const YAML::Exception& error) {
    throw ScenarioError(source, line_of(error.mark), "is no YAML: " + error.msg);
  }
}

void YamlValue::fail_wanted(const std::string& wanted) const {
  fail(key_ + " needs " + wanted + (node_.IsScalar() ? ", not '" + node_.Scalar() + "'" : ""));
}

double YamlValue::number(const Limits& limits) const {
  const double value = node_.IsScalar() ? node_.as<double>(NAN) : NAN;
  if (!(value >= limits.least && value <= limits.most)) fail_wanted(describe(limits));
  return value;
}

int YamlValue::whole(int least, int most) const {
  const int value = node_.IsScalar() ? node_.as<int>(least - 1) : least - 1;
  if (value < least || value > most) {
    fail_wanted("a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  }
  return value;
}

std::uint64_t YamlValue::natural() const {
  const bool has_digits = node_.IsScalar() && !node_.Scalar().empty() &&
                          node_.Scalar().find_first_not_of("0123456789") == std::string::npos;
  if (!has_digits || node_.Scalar().size() > 19) fail_wanted("a whole number of at least 0");
  return node_.as<std::uint64_t>();
}

bool YamlValue::truth() const {
  const bool is_truth = node_.IsScalar() && node_.as<bool>(false) == node_.as<bool>(true);
  if (!is_truth) fail_wanted("true or false");
  return node_.as<bool>();
}

std::string YamlValue::text() const {
  if (!node_.IsScalar() || node_.Scalar().empty()) fail_wanted("a word");
  return node_.Scalar();
}

std::vector<YamlValue> YamlValue::list() const {
  if (!is_list()) fail_wanted("a list");
  std::vector<YamlValue> values;
  for (const auto& item : node_) values.emplace_back(source_, key_, item, line_of(item.Mark()));
  return values;
}

std::vector<double> YamlValue::numbers(std::size_t least_count, std::size_t most_count,
                                       const Limits& limits) const {
  if (!is_list() || node_.size() < least_count || node_.size() > most_count) {
    const std::string count = std::to_string(least_count);
    fail_wanted("a list of " + count + (most_count > least_count ? " to " + std::to_string(most_count) : "") +
                " numbers");
  }
  std::vector<double> numbers;
  for (const YamlValue& value : list()) numbers.push_back(value.number(limits));
  return numbers;
}

Eigen::Vector2d YamlValue::vector2(const Limits& limits) const {
  return Eigen::Vector2d(numbers(2, 2, limits).data());
}

Eigen::Vector3d YamlValue::vector3(const Limits& limits) const {
  return Eigen::Vector3d(numbers(3, 3, limits).data());
}

YamlMap YamlValue::map() const { return YamlMap(*this); }

YamlMap::YamlMap(const YamlValue& value) : whole_(value) {
  if (!value.is_map()) value.fail_wanted("a list of `key: value`");
  std::set<std::string> keys;
  for (const auto& item : value.node_) {
    const int line = line_of(item.first.Mark());
    if (!item.first.IsScalar()) throw ScenarioError(value.source_, line, "a key must be a name");
    const std::string key = item.first.Scalar();
    if (!keys.insert(key).second) throw ScenarioError(value.source_, line, key + " is set twice");
    values_.emplace_back(value.source_, key, item.second, line);
  }
}

std::optional<YamlValue> YamlMap::find(const std::string& key) const {
  asked_.insert(key);
  const auto found =
      std::find_if(values_.begin(), values_.end(), [&](const YamlValue& v) { return v.key() == key; });
  return found == values_.end() || found->node_.IsNull() ? std::nullopt : std::optional(*found);
}

YamlValue YamlMap::get(const std::string& key) const {
  const std::optional<YamlValue> value = find(key);
  if (!value) whole_.fail(whole_.key() + " lacks " + key);
  return *value;
}

double YamlMap::number(const std::string& key, const Limits& limits, std::optional<double> otherwise) const {
  if (otherwise && !find(key)) return *otherwise;
  return get(key).number(limits);
}

YamlMap YamlMap::overridden(const YamlMap& overrides) const {
  YamlMap result = *this;
  for (const YamlValue& value : overrides.values_) {
    const auto old = std::find_if(result.values_.begin(), result.values_.end(),
                                  [&](const YamlValue& v) { return v.key() == value.key(); });
    if (old == result.values_.end()) {
      result.values_.push_back(value);
    } else {
      *old = value;
    }
  }
  return result;
}

void YamlMap::refuse_unknown() const {
  for (const YamlValue& value : values_) {
    if (asked_.contains(value.key())) continue;
    std::string known;
    for (const std::string& key : asked_) known += (known.empty() ? "" : " ") + key;
    value.fail("unknown key " + value.key() + "; known here: " + known);
  }
}

}  // namespace evermap
