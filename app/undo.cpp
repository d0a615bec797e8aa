// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>

#include <fmt/core.h>

#include "verbs.hpp"
#include <evermap/io/detail/map_undo.hpp>

namespace evermap {

void add_undo(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("undo", "Bring back the map before the last run with --undo-log");
  const auto map = std::make_shared<std::filesystem::path>();
  verb->add_option("MAP.evm", *map, "Map that the run wrote")->required();
  verb->callback([map] {
    undo_map(*map);
    fmt::print("map      {} is as it was before\n", map->string());
  });
}

}  // namespace evermap
