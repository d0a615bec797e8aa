// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/chrono.h>
#include <fmt/ranges.h>

#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/history/map_history.hpp>
#include <evermap/history/map_store.hpp>

namespace evermap {
namespace {

std::string utc(std::int64_t time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(time)));
}

void print_versions(const std::filesystem::path& map, bool as_json) {
  const std::vector<MapVersion> versions = MapHistory(map).versions();
  if (as_json) {
    Json all = Json::array();
    for (const MapVersion& version : versions) {
      all.push_back({{"version", version.number},
                     {"time", utc(version.time)},
                     {"cause", version.cause.what},
                     {"parameters", version.cause.parameters},
                     {"evermap", version.evermap},
                     {"leaves", version.leaves},
                     {"written", version.written},
                     {"removed", version.removed},
                     {"fingerprint", version.fingerprint},
                     {"tags", version.tags}});
    }
    fmt::print("{}", dump({{"map", map.string()}, {"versions", all}}));
    return;
  }
  for (auto version = versions.rbegin(); version != versions.rend(); ++version) {
    const std::string tags =
        version->tags.empty() ? "" : fmt::format("  ({})", fmt::join(version->tags, ", "));
    fmt::print("{:>5}  {}  {:>9} leaves, {:>8} written, {:>8} removed  {}{}\n", version->number,
               utc(version->time), version->leaves, version->written, version->removed, version->cause.what,
               tags);
  }
}

/// "30d", "12h", "2w": [s].
std::int64_t duration_of(const std::string& text) {
  const auto unit = text.empty() ? ' ' : text.back();
  const std::int64_t seconds = unit == 'h' ? 3600 : unit == 'd' ? 86400 : unit == 'w' ? 7 * 86400 : 0;
  const std::string digits = text.substr(0, text.empty() ? 0 : text.size() - 1);
  const bool is_number =
      !digits.empty() && digits.size() < 7 && digits.find_first_not_of("0123456789") == std::string::npos;
  if (seconds == 0 || !is_number)
    throw std::runtime_error("\"" + text.substr(0, 80) + "\" is no duration; write 12h, 30d or 8w");
  return seconds * std::stoll(digits);
}

std::string check_duration(const std::string& text) {
  try {
    duration_of(text);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

}  // namespace

void add_log(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("log", "List the versions of a map, the newest first");
  struct LogOptions {
    std::filesystem::path map;
    bool as_json = false;
  };
  const auto options = std::make_shared<LogOptions>();
  verb->add_option("MAP.evm", options->map, "Map whose history to list")->required();
  add_json_option(*verb, options->as_json);
  verb->callback([options] { print_versions(options->map, options->as_json); });
}

void add_checkout(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("checkout", "Write a version of a map to a file of its own");
  struct CheckoutOptions {
    std::filesystem::path version;
    std::filesystem::path output;
    double patience = 0;  ///< [s]
  };
  const auto options = std::make_shared<CheckoutOptions>();
  verb->add_option("VERSION", options->version, "map.evm@3, or map.evm@TAG")->required();
  verb->add_option("-o,--output", options->output, "Map to write")->required()->type_name("OUT.evm");
  add_wait_option(*verb, options->patience);
  verb->callback([options] {
    const Octree octree = load_map_version(options->version);
    MapStore store(options->output, options->patience);
    store.create(octree, {"checkout of " + options->version.string(), ""});
    fmt::print("map      {}\nleaves   {}\n", options->output.string(), octree.leaf_count());
  });
}

void add_tag(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("tag", "Name a version; it stays when others are pruned");
  struct TagOptions {
    std::filesystem::path map;
    std::string name;
    std::string version;  ///< empty: the newest
    double patience = 0;  ///< [s]
  };
  const auto options = std::make_shared<TagOptions>();
  verb->add_option("MAP.evm", options->map, "Map with a history")->required();
  verb->add_option("NAME", options->name, "Its new name")->required();
  verb->add_option("VERSION", options->version, "Number or tag")->default_str("the newest");
  add_wait_option(*verb, options->patience);
  verb->callback([options] {
    MapStore store(options->map, options->patience);
    fmt::print("version  {} of {} is {}\n", store.tag(options->name, options->version), options->map.string(),
               options->name);
  });
}

void add_prune(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("prune", "Drop old versions; the newest and those with a tag stay");
  struct PruneOptions {
    std::filesystem::path map;
    std::string keep = "30d";
    std::string keep_daily = "365d";
    double patience = 0;  ///< [s]
  };
  const auto options = std::make_shared<PruneOptions>();
  verb->add_option("MAP.evm", options->map, "Map with a history")->required();
  verb->add_option("--keep", options->keep, "Younger versions stay")
      ->check(CLI::Validator(check_duration, ""))
      ->type_name("TIME")
      ->capture_default_str();
  verb->add_option("--keep-daily", options->keep_daily, "Of younger days, the last version stays")
      ->check(CLI::Validator(check_duration, ""))
      ->type_name("TIME")
      ->capture_default_str();
  add_wait_option(*verb, options->patience);
  verb->callback([options] {
    MapStore store(options->map, options->patience);
    const int dropped = store.prune(duration_of(options->keep), duration_of(options->keep_daily));
    fmt::print("versions {} dropped, {} kept\n", dropped, MapHistory(options->map).versions().size());
  });
}

}  // namespace evermap
