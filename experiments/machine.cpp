// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/machine.hpp"

#include <fstream>
#include <iterator>
#include <sys/utsname.h>
#include <thread>

#include <Eigen/Core>
#include <fmt/format.h>
#include <oneapi/tbb/version.h>
#include <xxhash.h>

#include <evermap/evaluation/octomap_baseline.hpp>

namespace evermap {
namespace {

std::string system_name() {
  utsname name{};
  return ::uname(&name) == 0 ? fmt::format("{} {}", name.sysname, name.release) : "unknown";
}

}  // namespace

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

std::string compiler() {
#ifdef __clang__
  return __VERSION__;
#else
  return "GCC " __VERSION__;
#endif
}

std::string program_fingerprint() {
  static const std::string fingerprint = [] {
    std::ifstream file("/proc/self/exe", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    return fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size()));
  }();
  return fingerprint;
}

Json machine_facts() {
  return {{"processor", fmt::format("{}, {} cores", processor(), std::thread::hardware_concurrency())},
          {"system", system_name()},
          {"compiler", compiler()},
          {"evermap", fmt::format("{}, build {}", EVERMAP_VERSION, program_fingerprint())},
          {"OctoMap", OctoMapBaseline::version()},
          {"oneTBB", fmt::format("{}.{}", TBB_VERSION_MAJOR, TBB_VERSION_MINOR)},
          {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)}};
}

}  // namespace evermap
