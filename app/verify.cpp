// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include <fmt/core.h>

#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"
#include <evermap/history/map_repair.hpp>

namespace evermap {
namespace {

struct VerifyOptions {
  std::filesystem::path map;
  double patience = 0;  ///< [s]
  bool as_json = false;
};

void run_verify(const VerifyOptions& options) {
  const MapVerdict verdict = verify(options.map);
  if (options.as_json) {
    fmt::print("{}", dump({{"map", options.map.string()},
                           {"is_sound", verdict.is_sound()},
                           {"is_map_sound", verdict.is_map_sound},
                           {"versions", verdict.versions},
                           {"sound_versions", verdict.sound_versions},
                           {"damage", verdict.damage}}));
  } else {
    fmt::print("map      {} {}\nversions {} of {} sound\n", options.map.string(),
               verdict.is_map_sound ? "is sound" : "is damaged", verdict.sound_versions.size(),
               verdict.versions);
    for (const std::string& damage : verdict.damage) fmt::print("         {}\n", damage);
  }
  if (!verdict.is_sound())
    throw std::runtime_error(options.map.string() +
                             " or its history is damaged; evermap repair saves what can be saved");
}

}  // namespace

void add_verify(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("verify", "Read a map and all its versions, and say what is damaged");
  const auto options = std::make_shared<VerifyOptions>();
  verb->add_option("MAP.evm", options->map, "Map to check")->required();
  add_json_option(*verb, options->as_json);
  verb->callback([options] { run_verify(*options); });
}

void add_repair(CLI::App& app) {
  CLI::App* verb =
      app.add_subcommand("repair", "Make a damaged map whole from its history, or its history from the map");
  const auto options = std::make_shared<VerifyOptions>();
  verb->add_option("MAP.evm", options->map, "Map to repair")->required();
  add_wait_option(*verb, options->patience);
  verb->callback([options] {
    const std::vector<std::string> done = repair(options->map, options->patience);
    for (const std::string& line : done) fmt::print("repaired {}\n", line);
    if (done.empty()) fmt::print("map      {} is sound, nothing was done\n", options->map.string());
  });
}

}  // namespace evermap
