// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <csignal>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "files/file_fixture.hpp"

namespace evermap {

/// The program as a process of its own, its output in files.
class Process {
 public:
  /// `arguments` without the program's name.
  Process(std::vector<std::string> arguments, std::filesystem::path out, std::filesystem::path err)
      : out_(std::move(out)), err_(std::move(err)) {
    arguments.insert(arguments.begin(), EVERMAP_PROGRAM);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    std::filesystem::remove(err_);
    id_ = ::fork();
    if (id_ == 0) {
      redirect(out_, STDOUT_FILENO);
      redirect(err_, STDERR_FILENO);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
  }
  ~Process() {
    if (id_ <= 0) return;
    ::kill(id_, SIGKILL);
    wait();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal) const { ::kill(id_, signal); }
  /// The exit code; minus the signal when one ended it.
  int wait() {
    int status = 0;
    ::waitpid(std::exchange(id_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  static void redirect(const std::filesystem::path& file, int descriptor) {
    ::dup2(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), descriptor);
  }

  std::filesystem::path out_;
  std::filesystem::path err_;
  pid_t id_ = -1;
};

struct Result {
  int exit_code;
  std::string out;
  std::string err;
};

/// A test of the whole program, with a small world to drive through.
class ProgramTest : public FileTest {
 protected:
  std::unique_ptr<Process> start(std::vector<std::string> arguments) const {
    return std::make_unique<Process>(std::move(arguments), path("stdout"), path("stderr"));
  }
  Result run(std::vector<std::string> arguments) const {
    const int exit_code = start(std::move(arguments))->wait();
    return {exit_code, content(path("stdout")), content(path("stderr"))};
  }
  std::string name(const std::string& file) const { return path(file).string(); }

  void expect_done(const std::vector<std::string>& arguments) const {
    const Result result = run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
  }
  /// Exit code 1, one line that holds `text`, and no other output.
  void expect_failed(const std::vector<std::string>& arguments, const std::string& text) const {
    const Result result = run(arguments);
    EXPECT_EQ(result.exit_code, 1) << text;
    EXPECT_EQ(result.out, "") << text;
    const std::string program = std::filesystem::path(EVERMAP_PROGRAM).filename();
    EXPECT_TRUE(result.err.starts_with(program + ": ")) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_NE(result.err.find(text), std::string::npos) << result.err << "lacks: " << text;
    EXPECT_FALSE(std::filesystem::exists(path("out.evm"))) << text;
  }

  /// A KITTI scan from 1.7 m above ground in a round room of 20 m radius; a wall 8 m ahead when `has_wall`.
  static std::string room(bool has_wall, int columns = 720) {
    std::vector<float> values;
    for (int row = 0; row < 32; ++row) {
      for (int column = 0; column < columns; ++column) {
        const double elevation = -0.35 + 0.015 * row;
        const double azimuth = 2 * M_PI * column / columns;
        const double wall = has_wall && std::abs(azimuth - M_PI) < 0.3 ? 8 : 20;
        const double range =
            std::min(wall / std::cos(elevation), elevation < 0 ? -1.7 / std::sin(elevation) : 1e9);
        const double across = range * std::cos(elevation);
        for (const double x :
             {across * std::cos(azimuth), across * std::sin(azimuth), range * std::sin(elevation)}) {
          values.push_back(static_cast<float>(x));
        }
        values.push_back(0);
      }
    }
    return bytes_of(values);
  }
  /// A KITTI scan of a room with a pillar, from `x`, `y` in it: unlike the round one, it holds every
  /// direction. All that is in it, the sensor's height too, is `size` times as large.
  static std::string hall(double x, double y, double size = 1) {
    std::vector<float> values;
    for (int row = 0; row < 32; ++row) {
      for (int column = 0; column < 360; ++column) {
        const double elevation = -0.4 + 0.02 * row;
        const double azimuth = 2 * M_PI * column / 360;
        const double cx = std::cos(azimuth);
        const double cy = std::sin(azimuth);
        double across = std::min(((cx > 0 ? 12 : -9) - x) / cx, ((cy > 0 ? 7 : -8) - y) / cy);
        const double along = (5 - x) * cx + (3 - y) * cy;
        const double aside = std::abs((3 - y) * cx - (5 - x) * cy);
        if (along > 0 && aside < 1) across = std::min(across, along - std::sqrt(1 - aside * aside));
        double range = across / std::cos(elevation);
        if (elevation < 0) range = std::min(range, -1.7 / std::sin(elevation));
        for (const double value : {range * std::cos(elevation) * cx, range * std::cos(elevation) * cy,
                                   range * std::sin(elevation), 0.0}) {
          values.push_back(static_cast<float>(size * value));
        }
      }
    }
    return bytes_of(values);
  }
  /// A folder of these scans and a file of poses for them, each `forward` and `aside` [m] of the one before.
  void make_scans(const std::string& folder, const std::vector<std::string>& scans, double forward,
                  double aside) const {
    std::filesystem::create_directory(path(folder));
    std::string poses;
    for (std::size_t i = 0; i < scans.size(); ++i) {
      const auto steps = static_cast<double>(i);
      make(folder + "/" + std::to_string(10000 + i) + ".bin", scans[i]);
      poses += "1 0 0 " + std::to_string(forward * steps) + " 0 1 0 " + std::to_string(aside * steps) +
               " 0 0 1 0\n";
    }
    make(folder + ".txt", poses);
  }
  /// `count` scans of the room, all alike, that are said to be a centimetre apart.
  void make_drive(const std::string& folder, int count, bool has_wall) const {
    make_scans(folder, std::vector<std::string>(static_cast<std::size_t>(count), room(has_wall)), 0.01, 0);
  }
  /// A drive through the hall, whose scans tell where they were taken.
  void make_hall_drive(const std::string& folder, int count) const {
    std::vector<std::string> scans;
    for (int i = 0; i < count; ++i) scans.push_back(hall(0.1 * i, 0.02 * i));
    make_scans(folder, scans, 0.1, 0.02);
  }
  std::vector<std::string> build(const std::string& drive, const std::string& map) const {
    return {"build", name(drive), "--poses", name(drive + ".txt"), "-r", "0.4", "-o", name(map)};
  }
  std::vector<std::string> update(const std::string& map, const std::string& drive, const std::string& out,
                                  const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"update", name(map), name(drive), "--poses", name(drive + ".txt"),
                                          "-o",     name(out)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

}  // namespace evermap
