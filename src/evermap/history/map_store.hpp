// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <evermap/history/detail/file_stamp.hpp>
#include <evermap/history/map_history.hpp>
#include <evermap/io/detail/map_lock.hpp>
#include <evermap/map/octree.hpp>

namespace evermap {

/// How often a run that has not ended makes sure that what it did lasts.
struct JournalParameters {
  std::size_t scans = 10;  ///< after so many; 0: there is no journal
  double period = 1;       ///< [s] or after so long
};

/// A map file that this process alone changes, for as long as this object lives.
///
///   map.evm          the map as it is: all that a reader needs
///   map.evm.history  its versions, and the journal of the run that changes it
///   map.evm.lock     who changes it
///
/// A program that does not ask for the lock may put a map in place all the same: that one becomes a version
/// of its own, before the next one of ours.
///
/// What a killed process left unfinished is brought to its end by the constructor: a version that it had
/// stored is put into the map file, and the scans that its journal holds become a version. All functions
/// throw FileError. Not thread safe.
class MapStore {
 public:
  /// Waits up to `patience` [s] for another process.
  explicit MapStore(const std::filesystem::path& map, double patience = 0);
  ~MapStore();
  MapStore(const MapStore&) = delete;
  MapStore& operator=(const MapStore&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// What the constructor brought back, in words; empty when there was nothing.
  const std::string& recovered() const { return recovered_; }
  /// Whether a map was found that another program had put in place since this object read it.
  bool met_another_program() const { return met_another_program_; }

  Octree load();

  /// Puts a map in place of the one that is there, which stays in the history.
  void commit(const Octree& map, const MapCause& cause);
  /// Puts a new map in place; what was there stays only if it has a history, or if the cause tells of a run
  /// that was stopped.
  void create(const Octree& map, const MapCause& cause);

  /// From now on `acknowledge` keeps a journal of the run that begins with this map. What it wrote is given
  /// up when this object goes without commit().
  void begin(const Octree& map, const MapCause& cause, const JournalParameters& parameters = {});
  /// The run has taken `scans`, and its map is this, which is asked for only when it is to be written. When
  /// this returns true, a process that is killed at any later moment, or a power cut, leaves no less.
  bool acknowledge(const std::function<Octree()>& map, std::size_t scans);
  /// Whether acknowledge() would write.
  bool is_due(std::size_t scans) const;
  /// Whether acknowledge() has written: before, it may have to write the whole map first.
  bool has_journal() const;
  /// Ends the run in its journal alone, for who has no time to write the whole map: whoever opens it next
  /// puts in place what the run made. REQUIRES: has_journal().
  void leave(const Octree& map, std::size_t scans);

  /// Puts the version before in place, as a new version; returns its number.
  int undo();
  /// Names a version, given by its number or a tag; the newest when empty. Returns its number.
  int tag(const std::string& name, const std::string& version = {});
  /// Drops versions older than `keep` [s], except the last of each day for `keep_daily` [s], tagged ones, and
  /// the newest. Returns how many went.
  int prune(std::int64_t keep, std::int64_t keep_daily);

 private:
  struct Run;

  VersionTable& history();
  void recover();
  void start_journal();
  void write_journal(Octree reached, std::size_t scans);
  bool read_map();
  void note_outside_change();
  void append_outside_change();
  void save(const Octree& map);
  void put_in_place(const Octree& map, int version);

  std::filesystem::path path_;
  MapLock lock_;
  std::unique_ptr<VersionTable> history_;  ///< none while there is nothing to keep
  std::optional<Octree> in_place_;         ///< what the map file holds, once it was read
  FileStamp stamp_;                        ///< of the file that holds it
  bool is_foreign_ = false;                ///< another program put it there since it was read before
  std::string recovered_;
  bool met_another_program_ = false;
  std::unique_ptr<Run> run_;  ///< that keeps a journal
};

}  // namespace evermap
