// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <evermap/map/octree.hpp>

namespace evermap {

/// Why a map became what it is.
struct MapCause {
  std::string what;        ///< in words: "update with 60 scans of run/scans"
  std::string parameters;  ///< hash of all parameters; empty where none matter
  /// Of a run that was stopped before its end: the scans of its source that are in the map; else 0.
  std::size_t scans = 0;
};

/// A map as it was at one time.
struct MapVersion {
  int number;         ///< from 1, ascending
  std::int64_t time;  ///< [s] UTC, since 1970
  MapCause cause;
  std::string evermap;      ///< the library's version
  std::string fingerprint;  ///< of the whole map
  std::size_t leaves;       ///< of the whole map
  std::size_t written;      ///< leaves that differ from the version before, or came
  std::size_t removed;      ///< leaves that went
  bool is_whole;            ///< stored as a whole map, not as what changed
  bool is_in_place;         ///< was put into the map file
  std::vector<std::string> tags;
};

class VersionTable;
struct LeafChange;

/// Is told how a version came about, part by part: the map as it was before the part, and what changes.
using VersionVisitor =
    std::function<void(const MapVersion& version, const Octree& before, std::span<const LeafChange> changes)>;

/// The versions of a map, kept beside it in `map.evm.history`, a database of SQLite: the first as a whole,
/// each other as what changed. Reads only; MapStore writes. Throws FileError.
class MapHistory {
 public:
  /// REQUIRES: exists_for(map). While another process writes, this one sees the last version that it
  /// finished.
  explicit MapHistory(const std::filesystem::path& map);
  ~MapHistory();
  MapHistory(const MapHistory&) = delete;
  MapHistory& operator=(const MapHistory&) = delete;

  static bool exists_for(const std::filesystem::path& map);

  std::vector<MapVersion> versions() const;
  /// Whether a run was ended by force, or has not ended yet: MapStore brings that to its end.
  bool is_unfinished() const;
  /// The version of this number or tag; throws FileError when there is none.
  int number_of(const std::string& name) const;
  /// The map as it was, bit for bit; throws FileError when what is kept of it is damaged.
  /// `visit` sees it come about, from the last version on that was stored as a whole.
  Octree checkout(int number, const VersionVisitor& visit = {}) const;

 private:
  std::unique_ptr<VersionTable> table_;
};

/// Reads `map.evm`, or `map.evm@3` and `map.evm@tag`, a version of its history. Throws FileError.
Octree load_map_version(const std::filesystem::path& map);

}  // namespace evermap
