// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "experiments/result_cache.hpp"

#include <atomic>
#include <fstream>
#include <future>
#include <iterator>
#include <mutex>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include "command_line.hpp"
#include "experiments/machine.hpp"
#include "experiments/result_file.hpp"
#include <evermap/files/file_error.hpp>
#include <evermap/geometry/voxel_key.hpp>

namespace evermap {
namespace {

constexpr const char* kMark = "written_by_evermap_experiments";

/// The same text gives the same number in every build.
std::uint64_t fingerprint(const std::string& text) {
  std::uint64_t bits = 0;
  for (const char c : text) bits = hash_bits(bits + static_cast<unsigned char>(c));
  return bits;
}

}  // namespace

ResultCache::ResultCache(std::filesystem::path folder, bool any_build)
    : folder_(std::move(folder)), any_build_(any_build) {
  check_may_fill(folder_, "evermap_experiments", [&] { return std::filesystem::exists(folder_ / kMark); });
  std::error_code error;
  std::filesystem::create_directories(folder_ / "units", error);
  if (error) throw FileError(folder_, "the folder cannot be made: " + error.message());
  write_file(folder_ / kMark, "This folder may be written again by evermap_experiments.\n");
}

std::filesystem::path ResultCache::file_of(const Unit& unit) const {
  return folder_ / "units" /
         fmt::format("{}-{:08x}.json", unit.name, fingerprint(unit.settings.dump()) & 0xffffffffU);
}

std::optional<Json> ResultCache::stored(const Unit& unit) const {
  std::ifstream file(file_of(unit));
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const Json kept = Json::parse(text, nullptr, false);
  if (!kept.is_object() || !kept.contains("result")) return std::nullopt;
  const bool is_of_this_build = kept.value("program", Json()) == program_fingerprint();
  if (!(any_build_ || is_of_this_build) || kept.value("settings", Json()) != unit.settings)
    return std::nullopt;
  return kept["result"];
}

void ResultCache::compute(const std::vector<Unit>& units, const Watch& watch) const {
  std::mutex watching;
  const auto compute = [&](std::size_t i) {
    const auto tell = [&, i](std::size_t done, std::size_t total) {
      const std::scoped_lock lock(watching);
      watch(i, done, total);
    };
    tell(0, 1);
    result(units[i], tell);
  };
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < units.size(); i = next++) {
        if (!units[i].is_timed) compute(i);
      }
    } catch (...) {
      next = units.size();
      throw;
    }
  };
  // Threads besides TBB's: those wait within a unit for its slowest mapper, and take up no other unit.
  std::vector<std::future<void>> workers(
      oneapi::tbb::global_control::active_value(oneapi::tbb::global_control::max_allowed_parallelism));
  for (auto& worker : workers) worker = std::async(std::launch::async, work);
  for (auto& worker : workers) worker.get();
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (units[i].is_timed) compute(i);
  }
}

Json ResultCache::result(const Unit& unit, const Progress& progress) const {
  if (auto kept = stored(unit)) return *kept;
  Json result = unit.compute(progress);
  const Json whole{{"unit", unit.name},
                   {"program", program_fingerprint()},
                   {"settings", unit.settings},
                   {"result", result}};
  write_file(file_of(unit), dump(whole));
  // What is told must not depend on whether it was computed now or read.
  return Json::parse(dump(whole))["result"];
}

}  // namespace evermap
