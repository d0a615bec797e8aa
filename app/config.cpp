// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include <fmt/core.h>

#include "options.hpp"
#include "verbs.hpp"
#include <evermap/config/parameters_file.hpp>

namespace evermap {

void add_config(CLI::App& app) {
  CLI::App* verb =
      app.add_subcommand("config", "Print all parameters with their defaults, as a file for --config");
  const auto options = std::make_shared<ParameterOptions>();
  add_mode_option(*verb, *options);
  add_config_option(*verb, *options);
  verb->callback([options] { fmt::print("{}", to_yaml(parameters_of(*options))); });
}

}  // namespace evermap
