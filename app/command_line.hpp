// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include <CLI/CLI.hpp>

namespace evermap {

/// Work that a signal ended, after what was done was saved: the program exits by 128 + signal.
class Interrupted : public std::exception {
 public:
  explicit Interrupted(int signal) : signal_(signal) {}
  int signal() const { return signal_; }
  const char* what() const noexcept override { return "interrupted"; }

 private:
  int signal_;
};

/// What every program of evermap does around its command line: sets up logging and memory, parses, and runs
/// the callbacks that `add_options` adds. Every error is one line on the standard error. Returns the exit
/// code: 0, 1 when the work failed, 2 when it was called wrongly, 128 + signal when it was interrupted.
int run_command_line(int argc, char** argv, const std::string& program, const std::string& description,
                     const std::function<void(CLI::App&)>& add_options);

/// Throws FileError when `program`, filling the folder anew, would take away what others have put there:
/// unless there is no such folder yet, it is empty, or `is_ours` says that the program has filled it before.
void check_may_fill(const std::filesystem::path& folder, std::string_view program,
                    const std::function<bool()>& is_ours);

}  // namespace evermap
