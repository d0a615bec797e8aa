// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <exception>
#include <malloc.h>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "verbs.hpp"

namespace {

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;

/// Errors are one line each, even where a file's name is not.
std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' '; }, '?');
  return text;
}

/// Without this, a result that went to a full disk would pass for one that arrived.
void flush_results() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    throw std::runtime_error("the standard output cannot be written");
  }
}

/// What one scan needs, the next needs again. Left alone, glibc gives it back to the kernel in between, which
/// took up to half of a scan's time.
void keep_memory() {
  constexpr int kMegabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);
  mallopt(M_TRIM_THRESHOLD, 512 * kMegabyte);
}

void set_up(CLI::App& app, bool& is_verbose) {
  app.name("evermap");
  app.set_version_flag("--version", "evermap " EVERMAP_VERSION);
  app.add_flag("-v,--verbose", is_verbose, "Log what happens on the standard error");
  app.fallthrough();
  app.require_subcommand(1);
  app.option_defaults()->always_capture_default();
  app.get_formatter()->column_width(36);
  evermap::add_import(app);
  evermap::add_build(app);
  evermap::add_update(app);
  evermap::add_undo(app);
  evermap::add_localize(app);
  evermap::add_export(app);
  evermap::add_info(app);
  evermap::add_config(app);
  evermap::add_evaluate(app);
  evermap::add_demo(app);
  evermap::add_experiment(app);
  evermap::add_simulate(app);
}

}  // namespace

int main(int argc, char** argv) {
  keep_memory();
  try {
    spdlog::set_default_logger(spdlog::stderr_color_mt("evermap"));
    spdlog::set_pattern("%H:%M:%S.%e %l: %v");
    bool is_verbose = false;
    CLI::App app("Keeps a 3D LiDAR map true while the world changes.");
    set_up(app, is_verbose);
    app.parse_complete_callback(
        [&] { spdlog::set_level(is_verbose ? spdlog::level::debug : spdlog::level::warn); });
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      const bool asked_for = error.get_exit_code() == 0;  // --help, --version
      if (!asked_for) fmt::print(stderr, "evermap: {}; see evermap --help\n", one_line(error.what()));
      if (asked_for) app.exit(error);
      return asked_for ? kDone : kWrongUsage;
    }
    flush_results();
    return kDone;
  } catch (const std::exception& error) {
    fmt::print(stderr, "evermap: {}\n", one_line(error.what()));
    return kFailed;
  }
}
