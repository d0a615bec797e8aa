// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <evermap/history/detail/version_table.hpp>
#include <evermap/history/map_history.hpp>
#include <evermap/history/map_store.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

/// On a medium that cannot be written, SQLite must not try to note that it reads.
Database::Access access_to(const std::filesystem::path& file) {
  return ::access(file.parent_path().c_str(), W_OK) == 0 ? Database::Access::kShare
                                                         : Database::Access::kFrozen;
}

}  // namespace

MapHistory::MapHistory(const std::filesystem::path& map) {
  if (!exists_for(map))
    throw FileError(map, "has no history; it begins when update or localize --maintain changes a map");
  const std::filesystem::path file = VersionTable::path_of(map);
  table_ = std::make_unique<VersionTable>(file, access_to(file));
}
MapHistory::~MapHistory() = default;

bool MapHistory::exists_for(const std::filesystem::path& map) {
  std::error_code error;
  return std::filesystem::exists(VersionTable::path_of(map), error);
}

std::vector<MapVersion> MapHistory::versions() const {
  const std::vector<StoredVersion> all = table_->versions();
  return {all.begin(), all.end()};
}

int MapHistory::number_of(const std::string& name) const { return table_->number_of(name); }

bool MapHistory::is_unfinished() const {
  const std::vector<StoredVersion> all = table_->versions();
  return (!all.empty() && !all.back().is_in_place) || table_->has_journal();
}

Octree MapHistory::checkout(int number, const VersionVisitor& visit) const {
  return table_->checkout(number, visit);
}

Octree load_map_version(const std::filesystem::path& map) {
  const std::string name = map.string();
  const std::size_t at = name.rfind('@');
  std::error_code error;
  if (at != std::string::npos && !std::filesystem::exists(map, error)) {
    const std::filesystem::path file = name.substr(0, at);
    const MapHistory history(file);
    return history.checkout(history.number_of(name.substr(at + 1)));
  }
  try {
    if (MapHistory::exists_for(map) && MapHistory(map).is_unfinished()) return MapStore(map).load();
  } catch (const FileError&) {  // still being changed, or not ours to change: what is in place is a whole map
  }
  return load_map(map);
}

}  // namespace evermap
