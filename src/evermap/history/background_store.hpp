// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <future>
#include <string>

#include <evermap/history/map_store.hpp>

namespace evermap {

/// Lets a robot that is driving keep its map in a MapStore: the disk is written in a thread of its own, one
/// task at a time. Not thread safe; nobody else may use the store meanwhile.
class BackgroundStore {
 public:
  /// Begins a run with this map. The store must outlive this object.
  BackgroundStore(MapStore& store, const Octree& map, MapCause cause, const JournalParameters& journal);
  /// Waits for what is under way.
  ~BackgroundStore();

  /// Whether nothing is under way.
  bool is_idle();
  /// Why the last task failed; empty when it did not.
  const std::string& failure() const { return failure_; }

  /// Has the journal written if that is due, of a run that has taken `scans`; asks for the map only then.
  void acknowledge(const std::function<Octree()>& map, std::size_t scans);
  /// Ends the run; see MapStore::leave. REQUIRES: is_idle(), and that something was acknowledged.
  void leave(const Octree& map, std::size_t scans) { store_.leave(map, scans); }
  bool has_journal() const { return store_.has_journal(); }  ///< REQUIRES: is_idle()
  /// Makes a version of the map, and goes on with the run. REQUIRES: is_idle().
  void commit(Octree map, const std::string& what);
  /// Has something else written, which may throw FileError. REQUIRES: is_idle().
  void start(std::function<void()> task);
  void wait();

 private:
  void collect();

  MapStore& store_;
  MapCause cause_;
  JournalParameters journal_;
  std::future<void> task_;
  std::string failure_;
};

}  // namespace evermap
