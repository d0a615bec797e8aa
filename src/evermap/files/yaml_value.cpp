// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>

#include <yaml-cpp/yaml.h>

#include <evermap/files/detail/input_file.hpp>
#include <evermap/files/detail/text_lines.hpp>
#include <evermap/files/detail/yaml_value.hpp>

namespace evermap {

/// What yaml-cpp has read, in a form that later calls cannot change and threads may share.
struct YamlValue::Node {
  enum class Kind { kNothing, kScalar, kList, kMap };

  Kind kind = Kind::kNothing;
  std::string key;   ///< of the value in its map, or of the list that it is in
  std::string text;  ///< of a scalar
  int line = 1;      ///< of the key, or of a list's item
  std::vector<Node> items = {};
};

struct YamlValue::Text {
  std::filesystem::path source;
  Node root;
};

namespace {

constexpr std::size_t kMaxKeySize = 80;
constexpr int kMaxDepth = 64;
constexpr int kMaxValues = 1'000'000;  // aliases of aliases could be more than there is memory

int line_of(const YAML::Mark& mark) { return std::max(mark.line, 0) + 1; }

[[noreturn]] void fail_at(const std::filesystem::path& source, int line, const std::string& message) {
  throw FileError::at_line(source, static_cast<std::uint64_t>(line), message);
}

/// Digits as a person would write them.
std::string plain(double number) {
  std::string digits = std::to_string(number);
  digits.erase(digits.find_last_not_of('0') + 1);
  if (digits.back() == '.') digits.pop_back();
  return digits;
}

std::string describe(const Limits& limits) {
  const bool is_positive = limits.least == Limits::positive().least;
  if (limits.most >= Limits::any().most) {
    if (limits.least < 0) return "a number";
    return limits.least > 0 ? "a number above 0" : "a number of at least 0";
  }
  const std::string most = plain(limits.most);
  return is_positive ? "a number above 0, up to " + most
                     : "a number from " + plain(limits.least) + " to " + most;
}

/// Takes over the tree of one text.
template <class Node>
class TreeReader {
 public:
  explicit TreeReader(const std::filesystem::path& source) : source_(source) {}

  Node read(const YAML::Node& yaml, const std::string& key, int line, int depth = 0) {
    if (depth > kMaxDepth || ++values_ > kMaxValues) fail_at(source_, line, "holds too many values");
    Node node{Node::Kind::kNothing, key, {}, line};
    if (yaml.IsScalar()) {
      node.kind = Node::Kind::kScalar;
      node.text = yaml.Scalar();
    } else if (yaml.IsSequence()) {
      node.kind = Node::Kind::kList;
      for (const auto& item : yaml) node.items.push_back(read(item, key, line_of(item.Mark()), depth + 1));
    } else if (yaml.IsMap()) {
      node.kind = Node::Kind::kMap;
      read_entries(yaml, depth, node);
    }
    return node;
  }

 private:
  void read_entries(const YAML::Node& yaml, int depth, Node& node) {
    std::map<std::string, int> lines;
    for (const auto& item : yaml) {
      const int line = line_of(item.first.Mark());
      if (!item.first.IsScalar() || item.first.Scalar().size() > kMaxKeySize) {
        fail_at(source_, line, "a key must be a name of at most 80 letters");
      }
      const std::string key = item.first.Scalar();
      const auto [first, is_new] = lines.emplace(key, line);
      if (!is_new) {
        fail_at(source_, line,
                in_quotes(key) + " is set twice, first at line " + std::to_string(first->second));
      }
      node.items.push_back(read(item.second, key, line, depth + 1));
    }
  }

  const std::filesystem::path& source_;
  int values_ = 0;
};

}  // namespace

YamlValue YamlValue::read(const std::filesystem::path& path) {
  return parse(path, std::string(InputFile(path).bytes()));
}

YamlValue YamlValue::parse(const std::filesystem::path& source, const std::string& text) {
  try {
    Node root = TreeReader<Node>(source).read(YAML::Load(text), "the file", 1);
    const auto shared = std::make_shared<const Text>(Text{source, std::move(root)});
    return {shared, shared->root};
  } catch (const YAML::Exception& error) {
    fail_at(source, line_of(error.mark), "is no YAML: " + error.msg);
  }
}

const std::string& YamlValue::key() const { return node_->key; }
int YamlValue::line() const { return node_->line; }
bool YamlValue::is_nothing() const { return node_->kind == Node::Kind::kNothing; }
bool YamlValue::is_list() const { return node_->kind == Node::Kind::kList; }
bool YamlValue::is_map() const { return node_->kind == Node::Kind::kMap; }
bool YamlValue::is_word(std::string_view word) const {
  return node_->kind == Node::Kind::kScalar && node_->text == word;
}

void YamlValue::fail(const std::string& message) const { fail_at(text_->source, line(), message); }

void YamlValue::fail_wanted(const std::string& wanted) const {
  const bool is_scalar = node_->kind == Node::Kind::kScalar;
  fail(key() + " needs " + wanted + (is_scalar ? ", not " + in_quotes(node_->text) : ""));
}

double YamlValue::number(const Limits& limits) const {
  const std::optional<double> value = parse_number(node_->text);  // empty unless a scalar
  const bool is_within = value && *value >= limits.least && *value <= limits.most;
  if (!is_within) fail_wanted(describe(limits));
  return *value;
}

int YamlValue::whole(int least, int most) const {
  const std::optional<std::int64_t> value = parse_integer(node_->text);
  if (!value || *value < least || *value > most) {
    fail_wanted("a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  }
  return static_cast<int>(*value);
}

std::uint64_t YamlValue::natural() const {
  const std::optional<std::uint64_t> value = parse_count(node_->text);
  if (!value) fail_wanted("a whole number of at least 0");
  return *value;
}

bool YamlValue::truth() const {
  bool value = false;
  const bool is_truth =
      node_->kind == Node::Kind::kScalar && YAML::convert<bool>::decode(YAML::Node(node_->text), value);
  if (!is_truth) fail_wanted("true or false");
  return value;
}

std::string YamlValue::text() const {
  if (node_->text.empty()) fail_wanted("a word");
  return node_->text;
}

std::vector<YamlValue> YamlValue::list() const {
  if (!is_list()) fail_wanted("a list");
  std::vector<YamlValue> values;
  for (const Node& item : node_->items) values.push_back({text_, item});
  return values;
}

std::vector<double> YamlValue::numbers(std::size_t least_count, std::size_t most_count,
                                       const Limits& limits) const {
  if (!is_list() || node_->items.size() < least_count || node_->items.size() > most_count) {
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
  if (!value.is_map() && !value.is_nothing()) value.fail_wanted("a list of `key: value`");
  for (const YamlValue::Node& item : value.node_->items) {
    values_.push_back(YamlValue(value.text_, item));
  }
}

std::optional<YamlValue> YamlMap::find(const std::string& key) const {
  asked_.insert(key);
  const auto found =
      std::find_if(values_.begin(), values_.end(), [&](const YamlValue& v) { return v.key() == key; });
  return found == values_.end() || found->is_nothing() ? std::nullopt : std::optional(*found);
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

YamlMap YamlMap::section(const std::string& key) const {
  const std::optional<YamlValue> value = find(key);
  return value ? value->map() : YamlMap(whole_, {});
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

void YamlMap::refuse_unknown(std::string_view hint) const {
  for (const YamlValue& value : values_) {
    if (asked_.contains(value.key())) continue;
    std::string known(hint);
    if (hint.empty()) {
      for (const std::string& key : asked_) known += (known.empty() ? "known here: " : " ") + key;
    }
    value.fail("unknown key " + in_quotes(value.key()) + "; " + known);
  }
}

}  // namespace evermap
