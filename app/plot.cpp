// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "plot.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <spawn.h>
#include <stdexcept>
#include <string_view>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

#include "gnuplot_script.hpp"
#include <evermap/io/atomic_file.hpp>

namespace evermap {
namespace {

/// A new folder that vanishes with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "evermap-plot-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw std::system_error(errno, std::generic_category(), "a temporary folder cannot be made");
    }
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void save(const std::filesystem::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

/// Runs gnuplot in `folder` on its script.gp; what it says goes to messages.txt there.
void run_gnuplot(const std::filesystem::path& folder) {
  const std::string messages = (folder / "messages.txt").string();
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, messages.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  // -d: no file of settings of the user changes the picture.
  std::array<std::string, 3> words = {"gnuplot", "-d", "script.gp"};
  std::array<char*, 4> argv = {words[0].data(), words[1].data(), words[2].data(), nullptr};
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, "gnuplot", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT) throw std::runtime_error("plots need gnuplot: install the package gnuplot-nox");
  if (error != 0) throw std::system_error(error, std::generic_category(), "gnuplot cannot be started");
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  std::string said = content(messages);
  const std::size_t verdict = said.rfind("\"script.gp\"");  // before it, the command is repeated
  if (verdict != std::string::npos) said.erase(0, verdict);
  std::replace(said.begin(), said.end(), '\n', ' ');
  throw std::runtime_error("gnuplot failed: " + said);
}

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string csv(const std::vector<Plot>& panels) {
  std::string table = "panel,series,x,y,low,high\n";
  const auto interval_end = [](const std::vector<double>& values, std::size_t i) {
    return values.empty() ? std::string() : fmt::format("{}", values[i]);
  };
  for (const Plot& plot : panels) {
    for (const Series& series : plot.series) {
      for (std::size_t i = 0; i < series.y.size(); ++i) {
        const std::string x = plot.groups.empty() ? fmt::format("{}", series.x[i]) : csv_text(plot.groups[i]);
        table += fmt::format("{},{},{},{},{},{}\n", csv_text(plot.title), csv_text(series.name), x,
                             series.y[i], interval_end(series.low, i), interval_end(series.high, i));
      }
    }
  }
  return table;
}

void check(const Plot& plot) {
  const auto fail = [&](const std::string& what) {
    throw std::invalid_argument("plot \"" + plot.title + "\": " + what);
  };
  bool has_value = false;
  for (const Series& series : plot.series) {
    const std::size_t size = plot.groups.empty() ? series.x.size() : plot.groups.size();
    const auto fits = [&](const std::vector<double>& v) { return v.empty() || v.size() == series.y.size(); };
    if (series.y.size() != size || !fits(series.low) || !fits(series.high) ||
        series.low.empty() != series.high.empty()) {
      fail("the sizes of series \"" + series.name + "\" differ");
    }
    has_value |= std::any_of(series.y.begin(), series.y.end(),
                             [&](double y) { return std::isfinite(y) && (!plot.y.is_logarithmic || y > 0); });
  }
  if (!has_value) fail("it has no value to show");
}

}  // namespace

void write_plot(const std::filesystem::path& stem, const std::vector<Plot>& panels) {
  if (panels.empty()) throw std::invalid_argument(stem.string() + ": a plot without panels");
  for (const Plot& plot : panels) check(plot);
  const TemporaryFolder folder;
  save(folder.path() / "script.gp", gnuplot_script(panels));
  run_gnuplot(folder.path());
  const auto named = [&](const char* extension) { return std::filesystem::path(stem.string() + extension); };
  save(named(".png"), content(folder.path() / "plot.png"));
  save(named(".svg"), content(folder.path() / "plot.svg"));
  save(named(".csv"), csv(panels));
}

void write_plot(const std::filesystem::path& stem, const Plot& plot) { write_plot(stem, std::vector{plot}); }

}  // namespace evermap
