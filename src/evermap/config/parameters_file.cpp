// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include <evermap/config/parameters_file.hpp>
#include <evermap/files/detail/yaml_value.hpp>

namespace evermap {
namespace {

constexpr std::array kImpactRules = {std::pair(ImpactRule::kClosestApproach, "closest_approach"),
                                     std::pair(ImpactRule::kEquation5Inverse, "equation5_inverse"),
                                     std::pair(ImpactRule::kEquation5Printed, "equation5_printed")};
constexpr std::array kCombinations = {std::pair(Combination::kMaximum, "maximum"),
                                      std::pair(Combination::kNoisyOr, "noisy_or")};

const auto& names_of(ImpactRule) { return kImpactRules; }
const auto& names_of(Combination) { return kCombinations; }

constexpr Limits kFraction{0, 1};
constexpr Limits kLogOdds{0, 100};
constexpr Limits kAnyBool{0, 1};

/// Calls visit(name, field, unit, range, meaning) for every parameter. The bindings are the whole of each
/// struct: a new field does not compile until it is listed here.
template <class Lidar, class Visit>
void for_each_lidar_field(Lidar& lidar, Visit&& visit) {
  auto& [min_range, max_range, range_sigma, scan_period, vehicle_box] = lidar;
  visit("lidar.min_range", min_range, "m", Limits{0, 1000}, "nearer returns are not used");
  visit("lidar.max_range", max_range, "m", Limits{0.1, 10000}, "farther returns are not used");
  visit("lidar.range_sigma", range_sigma, "m", Limits{1e-4, 1}, "standard deviation of a return's distance");
  visit("lidar.scan_period", scan_period, "s", Limits{1e-3, 100}, "from a scan's first return to its last");
  visit("lidar.vehicle_box", vehicle_box, "m", Limits{-1000, 1000},
        "opposite corners, in the sensor's frame, of the vehicle, whose returns are not used");
}

template <class Update, class Visit>
void for_each_update_field(Update& update, Visit&& visit) {
  auto& [impact, combination, spare_reobserved, surface_crossing, trim_leaves, least_impact, extent_prior,
         patch_radius, hit_margin, surface_tolerance, hit, miss, max_log_odds, long_term_hit,
         long_term_max_log_odds, confirmations, max_count, settled, forgetting, rim_gone, standstill] =
      update;
  visit("update.impact", impact, "", Limits{}, "how a ray's contradiction of a leaf is measured");
  visit("update.combination", combination, "", Limits{},
        "how the impacts of one scan's bundles become one step");
  visit("update.spare_reobserved", spare_reobserved, "", kAnyBool,
        "a leaf whose surface the scan shows in a neighbouring voxel is spared");
  visit("update.surface_crossing", surface_crossing, "", kAnyBool,
        "a flat leaf is contradicted only by a ray that ends beyond its plane");
  visit("update.trim_leaves", trim_leaves, "", kAnyBool,
        "rays take from a leaf's geometry, too (equation 6 of the paper)");
  visit("update.least_impact", least_impact, "", kFraction, "smaller impacts are ignored");
  visit("update.extent_prior", extent_prior, "points", Limits{0, 1000},
        "weight of not knowing where in its voxel a surface is");
  visit("update.patch_radius", patch_radius, "standard deviations", Limits{0, 10},
        "so near to its middle, a flat leaf covers its plane");
  visit("update.hit_margin", hit_margin, "alignment errors", Limits{0, 10000},
        "before its hit, a ray contradicts no leaf without a plane");
  visit("update.surface_tolerance", surface_tolerance, "alignment errors", Limits{0, 1000},
        "by which a surface may seem displaced");
  visit("update.hit", hit, "log-odds", kLogOdds, "gained by one hit");
  visit("update.miss", miss, "log-odds", kLogOdds, "lost by one full contradiction");
  visit("update.max_log_odds", max_log_odds, "log-odds", kLogOdds,
        "most that a survey or a few hits can tell");
  visit("update.long_term_hit", long_term_hit, "log-odds", kLogOdds, "gained by each further hit");
  visit("update.long_term_max_log_odds", long_term_max_log_odds, "log-odds", kLogOdds,
        "most that many hits can tell");
  visit("update.confirmations", confirmations, "scans", Limits{1, 1000},
        "that must hit a new leaf before it is occupied");
  visit("update.max_count", max_count, "points", Limits{1, 1e6},
        "that a leaf remembers; older surface is forgotten");
  visit("update.settled", settled, "standard deviations", Limits{0, 100},
        "a known surface that a hit shows so near to where it was stays there; 0: never");
  visit("update.forgetting", forgetting, "", kFraction,
        "fraction of the remembered points that one full contradiction takes");
  visit("update.rim_gone", rim_gone, "", kFraction,
        "fraction of a region's rim beside leaves that went, with which the region goes; 0: never");
  visit("update.standstill", standstill, "m", Limits{0, 100},
        "a sensor that moved less sees the same again; 0: never");
}

template <class Localization, class Visit>
void for_each_localization_field(Localization& localization, Visit&& visit) {
  auto& [registration, gate, relocation] = localization;
  {
    auto& [termination, first_bundles, least_matches, first_kernel_width, last_kernel_width, settling_width,
           damping, least_inlier_fraction] = registration;
    auto& [max_iterations, least_translation, least_rotation] = termination;
    visit("registration.max_iterations", max_iterations, "", Limits{1, 1000}, "steps in search of a pose");
    visit("registration.least_translation", least_translation, "m", Limits{1e-6, 1},
          "a search ends with a shorter step");
    visit("registration.least_rotation", least_rotation, "rad", Limits{1e-6, 1},
          "a search ends with a smaller turn");
    visit("registration.first_bundles", first_bundles, "", Limits{50, 1e6},
          "bundles that find the pose; then all refine it");
    visit("registration.least_matches", least_matches, "", Limits{6, 1e6},
          "bundles on the map, below which a pose is a guess");
    visit("registration.first_kernel_width", first_kernel_width, "sigma", Limits{0.1, 100},
          "width of the robust kernel at first; halved from step to step");
    visit("registration.last_kernel_width", last_kernel_width, "sigma", Limits{0.1, 100},
          "width of the robust kernel at last");
    visit("registration.settling_width", settling_width, "sigma", Limits{0, 100},
          "of the last steps' kernel, in what is usual for bundles off their leaves; 0: no such steps");
    visit("registration.damping", damping, "", kFraction, "fraction of the Hessian's diagonal added to it");
    visit("registration.least_inlier_fraction", least_inlier_fraction, "", kFraction,
          "of the bundles, below which a scan does not fit the map");
  }
  {
    auto& [max_translation, max_rotation, max_growth, max_residual, least_inlier_fraction, max_contradicting,
           margin, memory, starting_slack, max_jump, max_turn_jump, lost_after] = gate;
    visit("gate.max_translation", max_translation, "m", Limits{0, 100}, "from a prediction over 0.1 s");
    visit("gate.max_rotation", max_rotation, "rad", Limits{0, 4}, "from a prediction over 0.1 s");
    visit("gate.max_growth", max_growth, "", Limits{1, 100},
          "by which what was usual may widen the two bounds above");
    visit("gate.max_residual", max_residual, "", Limits{1, 1000},
          "times the median of the scans that passed");
    visit("gate.least_inlier_fraction", least_inlier_fraction, "", kFraction,
          "times the median of the scans that passed");
    visit("gate.max_contradicting", max_contradicting, "", kFraction,
          "of a scan's rays, beyond the median; then other places are considered");
    visit("gate.rival", margin, "", kFraction,
          "of what the best place explains; by so much it must score better than others");
    visit("gate.memory", memory, "scans", Limits{5, 10000}, "that the medians are taken over");
    visit("gate.starting_slack", starting_slack, "", Limits{1, 100},
          "times the bounds while the motion is not known");
    visit("gate.max_jump", max_jump, "m", Limits{0, 100},
          "by which odometry may leave constant velocity in 0.1 s");
    visit("gate.max_turn_jump", max_turn_jump, "rad", Limits{0, 4},
          "by which odometry may leave constant velocity in 0.1 s");
    visit("gate.lost_after", lost_after, "scans", Limits{1, 10000}, "in a row that did not pass");
  }
  {
    auto& [reach, turn, step, turn_step, finalists] = relocation;
    visit("relocation.reach", reach, "m", Limits{0, 1000},
          "to either side, that a lost robot is searched in");
    visit("relocation.turn", turn, "rad", Limits{0, 3.15}, "to either side");
    visit("relocation.step", step, "m", Limits{0.01, 100}, "between places that are tried");
    visit("relocation.turn_step", turn_step, "rad", Limits{0.001, 3.15}, "between headings that are tried");
    visit("relocation.finalists", finalists, "", Limits{1, 1000}, "places that are registered in full");
  }
}

template <class Rollback, class Visit>
void for_each_rollback_field(Rollback& rollback, Visit&& visit) {
  auto& [scans] = rollback;
  visit("rollback.scans", scans, "scans", Limits{0, 10000},
        "whose changes are undone when the robot was lost");
}

template <class AnyParameters, class Visit>
void for_each_field(AnyParameters& parameters, Visit&& visit) {
  auto& [lidar, update, localization, rollback] = parameters;
  for_each_lidar_field(lidar, visit);
  for_each_update_field(update, visit);
  for_each_localization_field(localization, visit);
  for_each_rollback_field(rollback, visit);
}

template <class Field>
std::string to_string(const Field& field) {
  if constexpr (std::is_enum_v<Field>) {
    const auto& names = names_of(field);
    const auto found =
        std::find_if(names.begin(), names.end(), [&](const auto& n) { return n.first == field; });
    return found == names.end() ? "" : found->second;
  } else if constexpr (std::is_same_v<Field, Eigen::AlignedBox3d>) {
    if (field.isEmpty()) return "[]";
    return fmt::format("[{}, {}, {}, {}, {}, {}]", field.min().x(), field.min().y(), field.min().z(),
                       field.max().x(), field.max().y(), field.max().z());
  } else {
    return fmt::format("{}", field);
  }
}

/// What values the field can have, in words.
template <class Field>
std::string values_of(const Field& field, [[maybe_unused]] const Limits& limits) {
  if constexpr (std::is_enum_v<Field>) {
    std::string text;
    for (const auto& [value, name] : names_of(field))
      text += (text.empty() ? "" : " or ") + std::string(name);
    return text;
  } else if constexpr (std::is_same_v<Field, bool>) {
    return "true or false";
  } else if constexpr (std::is_same_v<Field, Eigen::AlignedBox3d>) {
    return "[] or [x, y, z, x, y, z]";
  } else {
    return fmt::format("{} to {}", limits.least, limits.most);
  }
}

template <class Field>
void set(Field& field, [[maybe_unused]] const Limits& limits, const YamlValue& value) {
  if constexpr (std::is_enum_v<Field>) {
    field = value.one_of<Field>(names_of(field));
  } else if constexpr (std::is_same_v<Field, bool>) {
    field = value.truth();
  } else if constexpr (std::is_same_v<Field, Eigen::AlignedBox3d>) {
    if (value.is_list() && value.list().empty()) return field.setEmpty();
    field = box_between(value.numbers(6, 6, limits));
  } else if constexpr (std::is_integral_v<Field>) {
    field = static_cast<Field>(value.whole(static_cast<int>(limits.least), static_cast<int>(limits.most)));
  } else {
    field = value.number(limits);
  }
}

}  // namespace

void read_parameters(const std::filesystem::path& path, Parameters& parameters) {
  const YamlMap root(YamlValue::read(path));
  std::map<std::string, YamlMap> sections;
  for_each_field(parameters,
                 [&](const std::string& name, auto& field, const char*, const Limits& limits, const char*) {
                   const std::size_t dot = name.find('.');
                   const std::string section = name.substr(0, dot);
                   const YamlMap& values = sections.try_emplace(section, root.section(section)).first->second;
                   if (const auto value = values.find(name.substr(dot + 1))) set(field, limits, *value);
                 });
  constexpr std::string_view kHint = "evermap config lists all";
  root.refuse_unknown(kHint);
  for (const auto& [name, section] : sections) section.refuse_unknown(kHint);
}

Eigen::AlignedBox3d box_between(const std::vector<double>& corners) {
  Eigen::AlignedBox3d box(Eigen::Vector3d(corners[0], corners[1], corners[2]));
  return box.extend(Eigen::Vector3d(corners[3], corners[4], corners[5]));
}

std::string to_yaml(const Parameters& parameters) {
  std::map<std::string, std::string> defaults;
  const Parameters standard;
  for_each_field(standard, [&](const std::string& name, const auto& field, const char*, const Limits&,
                               const char*) { defaults[name] = to_string(field); });
  std::string text;
  std::string section;
  for_each_field(parameters, [&](const std::string& name, const auto& field, const std::string& unit,
                                 const Limits& limits, const char* meaning) {
    const std::size_t dot = name.find('.');
    if (name.substr(0, dot) != section) {
      section = name.substr(0, dot);
      text += section + ":\n";
    }
    text +=
        fmt::format("  {:<40}  # {}{}, default {}: {}\n", name.substr(dot + 1) + ": " + to_string(field),
                    unit.empty() ? "" : "[" + unit + "] ", values_of(field, limits), defaults[name], meaning);
  });
  return text;
}

}  // namespace evermap
