// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "command_line.hpp"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <malloc.h>
#include <new>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <evermap/files/file_error.hpp>

namespace evermap {
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

/// An error line goes where it can: nobody may be there to read it.
void complain(const std::string& line) { std::fputs((line + "\n").c_str(), stderr); }

int run(int argc, char** argv, CLI::App& app, const std::function<void(CLI::App&)>& add_options) {
  spdlog::set_default_logger(spdlog::stderr_color_mt(app.get_name()));
  spdlog::set_pattern("%H:%M:%S.%e %l: %v");
  bool is_verbose = false;
  app.set_version_flag("--version", app.get_name() + " " EVERMAP_VERSION);
  app.add_flag("-v,--verbose", is_verbose, "Log what happens on the standard error");
  app.option_defaults()->always_capture_default();
  app.get_formatter()->column_width(36);
  add_options(app);
  app.parse_complete_callback(
      [&] { spdlog::set_level(is_verbose ? spdlog::level::debug : spdlog::level::warn); });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const bool asked_for = error.get_exit_code() == 0;  // --help, --version
    if (!asked_for) complain(fmt::format("{0}: {1}; see {0} --help", app.get_name(), one_line(error.what())));
    if (asked_for) app.exit(error);
    return asked_for ? kDone : kWrongUsage;
  }
  flush_results();
  return kDone;
}

}  // namespace

int run_command_line(int argc, char** argv, const std::string& program, const std::string& description,
                     const std::function<void(CLI::App&)>& add_options) {
  keep_memory();
  // A reader that went away, or a limit that was reached, is an error like others, after what was done is
  // saved.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    CLI::App app(description, program);
    return run(argc, argv, app, add_options);
  } catch (const Interrupted& interrupted) {
    constexpr int kSignalled = 128;
    return kSignalled + interrupted.signal();
  } catch (const std::bad_alloc&) {
    complain(program + ": not enough memory; a larger leaf edge or a smaller map needs less");
    return kFailed;
  } catch (const std::exception& error) {
    complain(program + ": " + one_line(error.what()));
    return kFailed;
  }
}

void check_may_fill(const std::filesystem::path& folder, std::string_view program,
                    const std::function<bool()>& is_ours) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(folder, error);
  if (!std::filesystem::exists(status)) return;
  if (!std::filesystem::is_directory(status)) throw FileError(folder, "is no folder; name another");
  if (std::filesystem::is_empty(folder, error) && !error) return;
  if (is_ours()) return;
  throw FileError(
      folder,
      fmt::format("holds files that {} did not write; name another folder, or an empty one", program));
}

}  // namespace evermap
