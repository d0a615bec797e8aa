// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "command_line.hpp"
#include "verbs.hpp"

int main(int argc, char** argv) {
  return evermap::run_command_line(argc, argv, "evermap",
                                   "Keeps a 3D LiDAR map true while the world changes.", [](CLI::App& app) {
                                     app.fallthrough();
                                     app.require_subcommand(1);
                                     evermap::add_import(app);
                                     evermap::add_build(app);
                                     evermap::add_update(app);
                                     evermap::add_localize(app);
                                     evermap::add_serve(app);
                                     evermap::add_play(app);
                                     evermap::add_view(app);
                                     evermap::add_export(app);
                                     evermap::add_info(app);
                                     evermap::add_config(app);
                                     evermap::add_evaluate(app);
                                     evermap::add_simulate(app);
                                     evermap::add_log(app);
                                     evermap::add_diff(app);
                                     evermap::add_checkout(app);
                                     evermap::add_undo(app);
                                     evermap::add_tag(app);
                                     evermap::add_prune(app);
                                     evermap::add_verify(app);
                                     evermap::add_repair(app);
                                   });
}
