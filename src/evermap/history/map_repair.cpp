// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <system_error>

#include <evermap/history/detail/version_table.hpp>
#include <evermap/history/map_repair.hpp>
#include <evermap/io/detail/map_lock.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

/// The versions that can be checked out, from whole to whole.
void verify_versions(VersionTable& table, MapVerdict& verdict) {
  const std::vector<StoredVersion> all = table.versions();
  verdict.versions = static_cast<int>(all.size());
  Octree octree(VoxelGrid{});
  std::string seal;
  bool is_followed = false;  // whether `octree` is the version before
  for (const StoredVersion& version : all) {
    if (version.is_whole || is_followed) {
      try {
        table.apply(version, octree);
        table.check(version, octree);
        if (version.before != seal && !seal.empty())
          verdict.damage.push_back("version " + std::to_string(version.number) +
                                   " does not follow the one before it");
        verdict.sound_versions.push_back(version.number);
        is_followed = true;
      } catch (const FileError& error) {
        verdict.damage.emplace_back(error.what());
        is_followed = false;
      }
    } else {
      verdict.damage.push_back("version " + std::to_string(version.number) + " is lost with one before it");
    }
    seal = version.seal;
  }
}

void set_aside(const std::filesystem::path& file, std::vector<std::string>& done) {
  std::filesystem::path aside = file;
  aside += ".damaged";
  std::error_code error;
  std::filesystem::rename(file, aside, error);
  if (error) throw FileError(aside, "cannot be made: " + error.message());
  done.push_back(file.string() + " was damaged; it is now " + aside.filename().string());
}

/// Leaves what can be checked out.
void drop_unsound(VersionTable& table, const std::vector<int>& sound, std::vector<std::string>& done) {
  std::string lost;
  Transaction transaction(table.database());
  for (const StoredVersion& version : table.versions()) {
    if (std::find(sound.begin(), sound.end(), version.number) != sound.end()) continue;
    table.remove(version.number);
    lost += (lost.empty() ? "" : ", ") + std::to_string(version.number);
  }
  table.clear_journal();
  transaction.commit();
  table.keep_only(std::vector<bool>(sound.size(), true));
  if (!lost.empty()) done.push_back("lost versions: " + lost);
}

}  // namespace

MapVerdict verify(const std::filesystem::path& map) {
  MapVerdict verdict;
  const bool has_history = MapHistory::exists_for(map);
  try {
    load_map(map);
    verdict.is_map_sound = true;
  } catch (const FileError& error) {
    if (!has_history) throw;
    verdict.damage.emplace_back(error.what());
  }
  if (!has_history) return verdict;
  const std::filesystem::path file = VersionTable::path_of(map);
  try {
    VersionTable table(file, Database::Access::kShare);
    verify_versions(table, verdict);
    if (table.has_journal()) table.journal();
  } catch (const FileError& error) {
    verdict.damage.emplace_back(error.what());
  }
  return verdict;
}

std::vector<std::string> repair(const std::filesystem::path& map, double patience) {
  std::vector<std::string> done;
  const MapLock lock(map, patience);
  const MapVerdict verdict = verify(map);
  if (verdict.is_sound()) return done;
  if (!verdict.is_map_sound && verdict.sound_versions.empty())
    throw FileError(map, "neither the map nor a version of it is sound; restore a copy");
  const std::filesystem::path file = VersionTable::path_of(map);
  if (verdict.sound_versions.empty()) {
    set_aside(file, done);
    std::error_code error;
    for (const char* suffix : {"-wal", "-shm"})
      std::filesystem::remove(std::filesystem::path(file) += suffix, error);
    done.push_back(map.string() + " is sound; its history begins anew");
    return done;
  }
  VersionTable table(file, Database::Access::kWrite);
  drop_unsound(table, verdict.sound_versions, done);
  const int newest = verdict.sound_versions.back();
  const Octree last = table.checkout(newest);
  if (!verdict.is_map_sound) {
    set_aside(map, done);
    save_map(map, last);
    table.set_in_place(newest);
    done.push_back(map.string() + " is version " + std::to_string(newest) + " now");
    return done;
  }
  const Octree in_place = load_map(map);
  if (fingerprint_of(in_place) != fingerprint_of(last)) {
    StoredVersion version;
    version.cause.what = "as it was found by repair";
    version.is_in_place = true;
    Transaction transaction(table.database());
    version = table.append(last, in_place, version);
    transaction.commit();
    done.push_back(map.string() + " is sound; it is version " + std::to_string(version.number) + " now");
  }
  return done;
}

}  // namespace evermap
