// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>

#include <fmt/core.h>

#include "options.hpp"
#include "verbs.hpp"
#include <evermap/io/detail/map_lock.hpp>
#include <evermap/io/detail/map_undo.hpp>

namespace evermap {

void add_undo(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("undo", "Bring back the map before the last run with --undo-log");
  struct UndoOptions {
    std::filesystem::path map;
    double patience = 0;  ///< [s]
  };
  const auto options = std::make_shared<UndoOptions>();
  verb->add_option("MAP.evm", options->map, "Map that the run wrote")->required();
  add_wait_option(*verb, options->patience);
  verb->callback([options] {
    const MapLock lock(options->map, options->patience);
    undo_map(options->map);
    fmt::print("map      {} is as it was before\n", options->map.string());
  });
}

}  // namespace evermap
