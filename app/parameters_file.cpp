// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "parameters_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <evermap/files/input_file.hpp>

namespace evermap {
namespace {

constexpr std::array kImpactRules = {std::pair(ImpactRule::kEquation5Inverse, "equation5_inverse"),
                                     std::pair(ImpactRule::kEquation5Printed, "equation5_printed"),
                                     std::pair(ImpactRule::kClosestApproach, "closest_approach")};
constexpr std::array kCombinations = {std::pair(Combination::kMaximum, "maximum"),
                                      std::pair(Combination::kNoisyOr, "noisy_or")};
constexpr std::array kSurfaceGuards = {std::pair(SurfaceGuard::kNone, "none"),
                                       std::pair(SurfaceGuard::kCoplanarHit, "coplanar_hit"),
                                       std::pair(SurfaceGuard::kReobserved, "reobserved")};
constexpr std::array kDifferences = {std::pair(Difference::kNone, "none"),
                                     std::pair(Difference::kSigmaPoints, "sigma_points"),
                                     std::pair(Difference::kSoft, "soft")};

const auto& names_of(ImpactRule) { return kImpactRules; }
const auto& names_of(Combination) { return kCombinations; }
const auto& names_of(SurfaceGuard) { return kSurfaceGuards; }
const auto& names_of(Difference) { return kDifferences; }

/// Calls visit(name, field, meaning) for every parameter. The bindings are the whole of each struct: a new
/// field does not compile until it is listed here.
template <class Parameters, class Visit>
void for_each_field(Parameters& parameters, Visit&& visit) {
  auto& [lidar, impact, combination, surface_guard, difference, surface_crossing, incidence_weight,
         least_impact, end_guard, displacement, hit, miss, max_log_odds, firming, firm_log_odds,
         confirmations, max_count, forgetting, standstill] = parameters;
  auto& [min_range, max_range, range_sigma] = lidar;
  visit("lidar.min_range", min_range, "[m] nearer returns are the vehicle itself");
  visit("lidar.max_range", max_range, "[m] farther returns are not used");
  visit("lidar.range_sigma", range_sigma, "[m] standard deviation of a return's distance");
  visit("impact", impact, "how a ray's contradiction of a leaf is measured");
  visit("combination", combination, "how the impacts of one scan's bundles become one step");
  visit("surface_guard", surface_guard, "evidence in the same scan that spares a leaf");
  visit("difference", difference, "what a contradicting ray takes from a leaf's Gaussian");
  visit("surface_crossing", surface_crossing,
        "a flat leaf is contradicted only by a ray ending beyond its plane");
  visit("incidence_weight", incidence_weight,
        "weigh a flat leaf's impact by |cos| of the angle of incidence");
  visit("least_impact", least_impact, "[0, 1] smaller impacts are ignored");
  visit("end_guard", end_guard,
        "[alignment errors of the scan] before a ray's hit, in which it contradicts no leaf without a plane");
  visit("displacement", displacement, "[alignment errors of the scan] how far a surface may seem displaced");
  visit("hit", hit, "[log-odds] gained by one hit");
  visit("miss", miss, "[log-odds] lost by one full contradiction");
  visit("max_log_odds", max_log_odds, "[log-odds] most that a survey or a few hits can tell");
  visit("firming", firming, "[log-odds] gained by each further hit");
  visit("firm_log_odds", firm_log_odds, "[log-odds] most that a leaf can gather");
  visit("confirmations", confirmations, "[scans] that must hit a new leaf before it is occupied");
  visit("max_count", max_count, "[points] a leaf's memory: older surface is forgotten beyond");
  visit("forgetting", forgetting, "[0, 1] share of this memory that one full contradiction takes");
  visit("standstill", standstill, "[m] a sensor that moved less sees the same again; 0: never");
}

template <class Field>
std::string to_string(const Field& field) {
  if constexpr (std::is_enum_v<Field>) {
    const auto& names = names_of(field);
    const auto found =
        std::find_if(names.begin(), names.end(), [&](const auto& n) { return n.first == field; });
    return found == names.end() ? "" : found->second;
  } else {
    return fmt::format("{}", field);
  }
}

/// The names that an enumeration can have; empty for all other fields.
template <class Field>
std::string alternatives(const Field& field) {
  std::string text;
  if constexpr (std::is_enum_v<Field>) {
    for (const auto& [value, name] : names_of(field)) text += (text.empty() ? "" : " | ") + std::string(name);
  }
  return text;
}

/// Sets `field` from a scalar; an empty string, or what was expected instead.
std::string set(double& field, const YAML::Node& node) {
  const double value = node.as<double>(NAN);
  if (!std::isfinite(value) || value < 0) return "a number of at least 0";
  field = value;
  return {};
}
std::string set(int& field, const YAML::Node& node) {
  const int value = node.as<int>(0);
  if (value < 1) return "a whole number of at least 1";
  field = value;
  return {};
}
std::string set(bool& field, const YAML::Node& node) {
  const bool is_bool = node.as<bool>(false) == node.as<bool>(true);  // otherwise each gives back its fallback
  if (!is_bool) return "true or false";
  field = node.as<bool>();
  return {};
}
template <class Enum>
requires std::is_enum_v<Enum> std::string set(Enum& field, const YAML::Node& node) {
  for (const auto& [value, name] : names_of(field)) {
    if (node.Scalar() != name) continue;
    field = value;
    return {};
  }
  return "one of " + alternatives(field);
}

std::uint64_t line_of(const YAML::Mark& mark) { return static_cast<std::uint64_t>(mark.line) + 1; }

struct Entry {
  std::string name;
  YAML::Node value;
  std::uint64_t line;
};

void collect(const InputFile& file, const YAML::Node& map, const std::string& prefix,
             std::vector<Entry>& entries) {
  for (const auto& item : map) {
    const std::uint64_t line = line_of(item.first.Mark());
    if (!item.first.IsScalar()) file.fail_at_line(line, "a key must be a name");
    const std::string name = prefix + item.first.Scalar();
    if (item.second.IsMap() && prefix.empty()) {
      collect(file, item.second, name + ".", entries);
    } else {
      entries.push_back({name, item.second, line});
    }
  }
}

void apply(const InputFile& file, const Entry& entry, UpdateParameters& parameters) {
  bool is_known = false;
  for_each_field(parameters, [&](const std::string& name, auto& field, const char*) {
    if (name != entry.name) return;
    is_known = true;
    const std::string wanted = entry.value.IsScalar() ? set(field, entry.value) : "one value";
    if (wanted.empty()) return;
    const std::string given = entry.value.IsScalar() ? ", not '" + entry.value.Scalar() + "'" : "";
    file.fail_at_line(entry.line, name + " needs " + wanted + given);
  });
  if (!is_known) file.fail_at_line(entry.line, "unknown key " + entry.name + "; evermap config lists all");
}

}  // namespace

void read_parameters(const std::filesystem::path& path, UpdateParameters& parameters) {
  const InputFile file(path);
  std::vector<Entry> entries;
  try {
    const YAML::Node root = YAML::Load(std::string(file.bytes()));
    if (root.IsNull()) return;  // nothing but comments
    if (!root.IsMap()) file.fail_at_line(line_of(root.Mark()), "is no list of `key: value`");
    collect(file, root, "", entries);
  } catch (const YAML::Exception& error) {
    file.fail_at_line(line_of(error.mark), "is no YAML: " + error.msg);
  }
  std::map<std::string, std::uint64_t> lines;
  for (const Entry& entry : entries) {
    const auto [first, is_new] = lines.emplace(entry.name, entry.line);
    if (!is_new) {
      file.fail_at_line(entry.line, entry.name + " was set before, at line " + std::to_string(first->second));
    }
    apply(file, entry, parameters);
  }
}

std::string to_yaml(const UpdateParameters& parameters) {
  std::string text;
  std::string section;
  for_each_field(parameters, [&](std::string name, const auto& field, const char* meaning) {
    const std::size_t dot = name.find('.');
    if (dot != std::string::npos) {
      if (name.substr(0, dot) != section) text += name.substr(0, dot) + ":\n";
      section = name.substr(0, dot);
      name = "  " + name.substr(dot + 1);
    }
    const std::string names = alternatives(field);
    text += fmt::format("{:<38}  # {}{}\n", name + ": " + to_string(field), meaning,
                        names.empty() ? "" : ": " + names);
  });
  return text;
}

}  // namespace evermap
