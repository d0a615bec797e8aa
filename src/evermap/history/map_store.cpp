// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <ctime>
#include <system_error>
#include <utility>
#include <vector>

#include <evermap/history/detail/pruning.hpp>
#include <evermap/history/detail/version_table.hpp>
#include <evermap/history/map_store.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

StoredVersion version_of(const MapCause& cause, bool is_in_place) {
  StoredVersion version;
  version.cause = cause;
  version.is_in_place = is_in_place;
  return version;
}

/// Condensing a journal means to read the map, so a journal may grow to about its size first.
std::size_t most_journal_bytes(const Octree& map) {
  constexpr std::size_t kLeast = std::size_t{16} << 20;
  return std::max(kLeast, sizeof(Leaf) * map.leaf_count());
}

}  // namespace

/// A run that has not ended.
struct MapStore::Run {
  using Clock = std::chrono::steady_clock;

  MapCause cause;
  JournalParameters parameters;
  Octree journaled;           ///< the map as far as the journal tells it
  StoredVersion newest = {};  ///< what the journal continues
  std::size_t scans = 0;      ///< that are acknowledged
  Clock::time_point time = Clock::now();
  std::size_t journal_bytes = 0;
  std::size_t most_journal_bytes = 0;  ///< before it is condensed
  bool is_begun = false;               ///< whether anything was written
  bool is_ending = false;  ///< its map is being stored: whatever happens, what it did is not given up
};

MapStore::MapStore(const std::filesystem::path& map, double patience) : path_(map), lock_(map, patience) {
  if (!MapHistory::exists_for(path_)) return;
  history();
  recover();
}

MapStore::~MapStore() {
  if (run_ == nullptr || !run_->is_begun || run_->is_ending) return;
  try {
    history_->clear_journal();
  } catch (const FileError&) {  // then the next process takes it for a run that was killed
  }
}

VersionTable& MapStore::history() {
  if (history_ == nullptr) {
    const std::filesystem::path file = VersionTable::path_of(path_);
    const bool is_new = !MapHistory::exists_for(path_);
    history_ = std::make_unique<VersionTable>(file, Database::Access::kWrite);
    if (is_new) sync_folder_of(file);
  }
  return *history_;
}

/// Ends what a killed process began. First its last version, which the map file may lack; then its journal.
void MapStore::recover() {
  const std::vector<StoredVersion> all = history_->versions();
  if (all.empty()) return;
  const int newest = all.back().number;
  if (!all.back().is_in_place) {
    put_in_place(history_->checkout(newest), newest);
    recovered_ =
        "version " + std::to_string(newest) + " was stored when a run was ended by force; it is in place now";
  }
  const Journal journal = history_->journal();
  if (journal.changes.empty()) return;
  const Octree before = history_->checkout(newest);
  Octree map = before;
  apply_changes(journal.changes, map);
  const std::string words =
      journal.cause.what + ", ended by force after " + std::to_string(journal.scans) + " scans";
  Transaction transaction(history_->database());
  const StoredVersion version =
      history_->append(before, map, version_of({words, journal.cause.parameters, journal.scans}, false));
  history_->clear_journal();
  transaction.commit();
  // What somebody put in the map's place since is more recent.
  if (read_map() && fingerprint_of(*in_place_).hex() != all.back().fingerprint) {
    history_->set_in_place(version.number);
    note_outside_change();
  } else {
    put_in_place(map, version.number);
  }
  recovered_ = "the run before was ended by force; the map is as it was after " +
               std::to_string(journal.scans) + " of its scans (version " + std::to_string(version.number) +
               ")";
}

/// False when there is no sound map in the file.
bool MapStore::read_map() {
  const FileStamp stamp = stamp_of(path_);
  if (in_place_ && stamp_ == stamp) return true;
  is_foreign_ = in_place_.has_value();
  in_place_.reset();
  try {
    in_place_ = load_map(path_);
    stamp_ = stamp;
  } catch (const FileError&) {
    return false;
  }
  return true;
}

Octree MapStore::load() {
  stamp_ = stamp_of(path_);  // first: who replaces the file now is noticed later
  in_place_ = load_map(path_);
  return *in_place_;
}

/// The history knows of every map that was in place.
void MapStore::note_outside_change() {
  Transaction transaction(history().database());
  append_outside_change();
  transaction.commit();
}

void MapStore::append_outside_change() {
  if (!read_map()) return;
  const std::vector<StoredVersion> all = history().versions();
  const bool is_known = !all.empty() && all.back().fingerprint == fingerprint_of(*in_place_).hex() &&
                        all.back().frame == in_place_->frame();
  if (is_known) return;
  met_another_program_ = met_another_program_ || is_foreign_;
  const Octree before = all.empty() ? Octree(in_place_->grid()) : history_->checkout(all.back().number);
  history_->append(
      before, *in_place_,
      version_of({all.empty() ? "as it was found" : "replaced by another program", "", 0}, true));
}

void MapStore::save(const Octree& map) {
  save_map(path_, map);
  in_place_ = map;
  stamp_ = stamp_of(path_);
  is_foreign_ = false;
}

void MapStore::put_in_place(const Octree& map, int version) {
  save(map);
  history_->set_in_place(version);
}

void MapStore::commit(const Octree& map, const MapCause& cause) {
  if (run_) run_->is_ending = true;
  // A first version is no history yet, unless there is more to be told of it than the map.
  if (!MapHistory::exists_for(path_) && cause.scans == 0 && !read_map()) {
    save(map);
  } else {
    // Both versions or none: the journal that ends with them continues the version before.
    Transaction transaction(history().database());
    append_outside_change();
    // A file that holds no map is replaced; the history goes on from what it held before.
    const std::vector<StoredVersion> all = history().versions();
    const Octree before = in_place_     ? *in_place_
                          : all.empty() ? Octree(map.grid())
                                        : history_->checkout(all.back().number);
    const StoredVersion version = history_->append(before, map, version_of(cause, false));
    history_->clear_journal();
    transaction.commit();
    put_in_place(map, version.number);
  }
  run_.reset();
}

void MapStore::create(const Octree& map, const MapCause& cause) {
  if (MapHistory::exists_for(path_) || cause.scans > 0) return commit(map, cause);
  save(map);
}

void MapStore::begin(const Octree& map, const MapCause& cause, const JournalParameters& parameters) {
  if (parameters.scans == 0) return;
  run_ = std::make_unique<Run>(Run{.cause = cause, .parameters = parameters, .journaled = map});
}

/// The journal tells what changed, so the map with which the run began must be the newest version.
void MapStore::start_journal() {
  std::unique_ptr<Run> run = std::move(run_);
  const bool is_in_place = read_map() && fingerprint_of(*in_place_) == fingerprint_of(run->journaled);
  if (!is_in_place) commit(run->journaled, {"begin of: " + run->cause.what, run->cause.parameters, 0});
  note_outside_change();
  run->newest = history().versions().back();
  run->most_journal_bytes = most_journal_bytes(run->journaled);
  run->is_begun = true;
  run_ = std::move(run);
}

bool MapStore::is_due(std::size_t scans) const {
  return run_ != nullptr &&
         (scans >= run_->scans + run_->parameters.scans ||
          Run::Clock::now() >= run_->time + std::chrono::duration<double>(run_->parameters.period));
}

bool MapStore::acknowledge(const std::function<Octree()>& map, std::size_t scans) {
  if (!is_due(scans)) return false;
  if (!run_->is_begun) start_journal();
  write_journal(map(), scans);
  return true;
}

void MapStore::write_journal(Octree reached, std::size_t scans) {
  const auto now = Run::Clock::now();
  run_->journal_bytes +=
      history_->append_to_journal(run_->newest, run_->journaled, reached, scans, run_->cause);
  if (run_->journal_bytes > run_->most_journal_bytes) {
    run_->journal_bytes = history_->condense_journal(run_->newest, reached, scans, run_->cause);
    run_->most_journal_bytes = most_journal_bytes(reached) + 2 * run_->journal_bytes;
  }
  run_->journaled = std::move(reached);
  run_->scans = scans;
  run_->time = now;
}

bool MapStore::has_journal() const { return run_ != nullptr && run_->is_begun; }

void MapStore::leave(const Octree& map, std::size_t scans) {
  write_journal(map, scans);
  run_.reset();
}

int MapStore::undo() {
  std::vector<StoredVersion> all;
  if (MapHistory::exists_for(path_)) {
    note_outside_change();
    all = history().versions();
  }
  if (all.size() < 2) throw FileError(path_, "no version before this one was kept");
  const StoredVersion& before = all[all.size() - 2];
  commit(history_->checkout(before.number), {"undo of version " + std::to_string(all.back().number), "", 0});
  return before.number;
}

int MapStore::tag(const std::string& name, const std::string& version) {
  if (!MapHistory::exists_for(path_)) throw FileError(path_, "has no history");
  const bool is_name =
      name.size() <= 80 && name.find_first_not_of("0123456789") != std::string::npos &&
      std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c < 127 && c != '@'; });
  if (!is_name) throw FileError(path_, "a tag is a word of at most 80 characters, no number, without @");
  const int number = version.empty() ? history().versions().back().number : history().number_of(version);
  history_->tag(name, number);
  return number;
}

int MapStore::prune(std::int64_t keep, std::int64_t keep_daily) {
  if (!MapHistory::exists_for(path_)) throw FileError(path_, "has no history");
  const std::vector<bool> is_kept = which_to_keep(history().versions(), keep, keep_daily, std::time(nullptr));
  history_->keep_only(is_kept);
  return static_cast<int>(std::count(is_kept.begin(), is_kept.end(), false));
}

}  // namespace evermap
