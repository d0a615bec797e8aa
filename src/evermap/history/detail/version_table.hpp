// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <evermap/files/detail/database.hpp>
#include <evermap/history/detail/packed_changes.hpp>
#include <evermap/history/map_history.hpp>

namespace evermap {

/// A row of the history, with what is for the history alone.
struct StoredVersion : MapVersion {
  VoxelGrid grid;
  MapFrame frame;
  std::string before;  ///< seal of the version before; empty for the first
  std::string seal;    ///< of all the above
};

/// What a run that has not ended has acknowledged since the newest version.
struct Journal {
  MapCause cause;         ///< of the run
  std::size_t scans = 0;  ///< that it had taken
  std::vector<LeafChange> changes;
};

/// The tables of `map.evm.history`:
///
///   version   a row a version; each is sealed together with the seal of the one before
///   change    what a version changed, in parts of at most kMostPacked leaves
///   frame     of the versions that are stored as a whole, where it is not the usual one
///   progress  of versions that a run left which was stopped, how many of its scans they have
///   tag       names of versions
///   run       the run that has not ended, if there is one
///   journal   what it changed since the newest version, in the order in which that was acknowledged
class VersionTable {
 public:
  VersionTable(const std::filesystem::path& path, Database::Access access);

  /// The history of a map, behind links.
  static std::filesystem::path path_of(const std::filesystem::path& map);

  Database& database() { return database_; }
  std::vector<StoredVersion> versions();
  /// The version of this number or tag. Throws FileError when there is none.
  int number_of(const std::string& name);
  /// Reads a version's changes, part by part.
  void for_each_part(const StoredVersion& version,
                     const std::function<void(std::span<const LeafChange>)>& visit);
  /// Makes the map of the version before to the map of this one.
  void apply(const StoredVersion& version, Octree& octree, const VersionVisitor& visit = {});
  /// Throws FileError when the map is not the one that this version was.
  void check(const StoredVersion& version, const Octree& octree) const;
  Octree checkout(int number, const VersionVisitor& visit = {});
  Journal journal();
  bool has_journal();

  /// Adds a version after the newest; number, time and what depends on the changes are filled in. REQUIRES: a
  /// transaction.
  StoredVersion append(const Octree& before, const Octree& after, StoredVersion version);
  void set_in_place(int number);
  /// Drops the other versions; those that follow one then tell what changed since the last that was kept. One
  /// flag a version. REQUIRES: the newest is kept.
  void keep_only(const std::vector<bool>& is_kept);
  void remove(int number);  ///< REQUIRES: a transaction
  /// Adds what a run has changed further since `newest`; lasts when it returns the bytes that this took.
  std::size_t append_to_journal(const StoredVersion& newest, const Octree& before, const Octree& after,
                                std::size_t scans, const MapCause& cause);
  /// Makes a journal that tells `after`, too, but each leaf once; returns its bytes.
  std::size_t condense_journal(const StoredVersion& newest, const Octree& after, std::size_t scans,
                               const MapCause& cause);
  void clear_journal();
  void tag(const std::string& name, int number);

 private:
  void insert(StoredVersion& version, const std::vector<LeafChange>& changes);
  std::size_t insert_into_journal(const StoredVersion& newest, const std::vector<LeafChange>& changes,
                                  std::size_t scans, const MapCause& cause);
  std::int64_t last_part_of_journal();

  std::int64_t read_format();
  bool has_table(const std::string& name);
  void read_frames(std::vector<StoredVersion>& versions);
  void read_progress(std::vector<StoredVersion>& versions);

  Database database_;
  bool is_begun_ = false;  ///< false of a file in which a killed process had not made the tables yet
};

/// What a version's row must say to be the one that was written.
std::string seal_of(const StoredVersion& version);

}  // namespace evermap
