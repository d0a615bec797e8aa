// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>

#include <fmt/core.h>

#include "options.hpp"
#include "verbs.hpp"
#include <evermap/history/map_store.hpp>

namespace evermap {

void add_undo(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("undo", "Bring back the version before; another undo takes that back");
  struct UndoOptions {
    std::filesystem::path map;
    double patience = 0;  ///< [s]
  };
  const auto options = std::make_shared<UndoOptions>();
  verb->add_option("MAP.evm", options->map, "Map that a run changed")->required();
  add_wait_option(*verb, options->patience);
  verb->callback([options] {
    MapStore store(options->map, options->patience);
    fmt::print("map      {} is as version {} was\n", options->map.string(), store.undo());
  });
}

}  // namespace evermap
