// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <bit>
#include <ctime>
#include <iterator>
#include <optional>
#include <utility>

#include <xxhash.h>

#include <evermap/history/detail/version_table.hpp>

namespace evermap {
namespace {

constexpr int kFormat = 1;
constexpr const char* kAdvice = "evermap repair saves what can be saved";
constexpr const char* kTables =
    "CREATE TABLE IF NOT EXISTS version(number INTEGER PRIMARY KEY, time INTEGER, what TEXT, parameters TEXT,"
    " evermap TEXT, fingerprint TEXT, edge REAL, x REAL, y REAL, z REAL, leaves INTEGER, written INTEGER,"
    " removed INTEGER, is_whole INTEGER, before TEXT, seal TEXT, is_in_place INTEGER);"
    "CREATE TABLE IF NOT EXISTS change(version INTEGER, part INTEGER, data BLOB, PRIMARY KEY(version, part));"
    "CREATE TABLE IF NOT EXISTS frame(version INTEGER PRIMARY KEY, name TEXT, latitude REAL, longitude REAL,"
    " altitude REAL);"
    "CREATE TABLE IF NOT EXISTS progress(version INTEGER PRIMARY KEY, scans INTEGER);"
    "CREATE TABLE IF NOT EXISTS tag(name TEXT PRIMARY KEY, version INTEGER);"
    "CREATE TABLE IF NOT EXISTS run(what TEXT, parameters TEXT);"
    "CREATE TABLE IF NOT EXISTS journal(part INTEGER PRIMARY KEY, scans INTEGER, data BLOB);";

std::uint64_t hash_of(const std::string& text) { return XXH3_64bits(text.data(), text.size()); }

/// What a part of a version's changes, or of the journal after it, belongs to.
std::uint64_t owner_of(const char* table, const StoredVersion& version, std::int64_t part) {
  return hash_of(std::string(table) + ' ' + std::to_string(version.number) + ' ' + version.fingerprint + ' ' +
                 std::to_string(part));
}

/// Calls visit(part) for stretches of at most kMostPacked changes.
template <class Visit>
void for_each_stretch(const std::vector<LeafChange>& changes, Visit&& visit) {
  for (std::size_t at = 0; at < changes.size(); at += kMostPacked)
    visit(std::span(changes).subspan(at, std::min(kMostPacked, changes.size() - at)));
}

}  // namespace

std::string seal_of(const StoredVersion& v) {
  std::string all = v.before;
  for (const std::string& text : {v.cause.what, v.cause.parameters, v.evermap, v.fingerprint})
    all += '\n' + text;
  for (const double value : {v.grid.edge, v.grid.origin.x(), v.grid.origin.y(), v.grid.origin.z()})
    all += '\n' + std::to_string(std::bit_cast<std::uint64_t>(value));
  all += '\n' + std::to_string(v.number) + ' ' + std::to_string(v.time) + ' ' + std::to_string(v.leaves);
  if (v.cause.scans > 0) all += '\n' + std::to_string(v.cause.scans);
  if (v.frame != MapFrame{}) {
    all += '\n' + v.frame.name;
    const MapFrame::GeoPoint origin = v.frame.origin.value_or(MapFrame::GeoPoint{});
    for (const double value : {origin.latitude, origin.longitude, origin.altitude})
      all += '\n' + std::to_string(std::bit_cast<std::uint64_t>(value));
  }
  const XXH128_hash_t hash = XXH3_128bits(all.data(), all.size());
  return Fingerprint{hash.low64, hash.high64}.hex();
}

VersionTable::VersionTable(const std::filesystem::path& path, Database::Access access)
    : database_(path, access, "history of a map", kAdvice) {
  if (access == Database::Access::kWrite) {
    database_.execute(
        "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA journal_size_limit = 4194304;");
    Transaction transaction(database_);
    database_.execute(kTables);
    if (read_format() == 0) database_.execute("PRAGMA user_version = " + std::to_string(kFormat));
    transaction.commit();
  }
  const std::int64_t format = read_format();
  if (format > kFormat) {
    throw FileError(path, "made by a newer evermap: format " + std::to_string(format) +
                              ", this program reads up to " + std::to_string(kFormat) + "; update evermap");
  }
  is_begun_ = format > 0;
}

std::int64_t VersionTable::read_format() {
  Statement format(database_, "PRAGMA user_version");
  format.step();
  return format.integer(0);
}

std::filesystem::path VersionTable::path_of(const std::filesystem::path& map) {
  std::error_code error;
  std::filesystem::path path = std::filesystem::weakly_canonical(map, error);
  if (error) path = map;
  return path += ".history";
}

std::vector<StoredVersion> VersionTable::versions() {
  std::vector<StoredVersion> found;
  if (!is_begun_) return found;
  Statement rows(
      database_,
      "SELECT number, time, what, parameters, evermap, fingerprint, edge, x, y, z, leaves, written, "
      "removed, is_whole, before, seal, is_in_place FROM version ORDER BY number");
  while (rows.step()) {
    StoredVersion v;
    v.number = static_cast<int>(rows.integer(0));
    v.time = rows.integer(1);
    v.cause = {rows.text(2), rows.text(3), 0};
    v.evermap = rows.text(4);
    v.fingerprint = rows.text(5);
    v.grid = {rows.real(6), {rows.real(7), rows.real(8), rows.real(9)}};
    v.leaves = static_cast<std::size_t>(rows.integer(10));
    v.written = static_cast<std::size_t>(rows.integer(11));
    v.removed = static_cast<std::size_t>(rows.integer(12));
    v.is_whole = rows.integer(13) != 0;
    v.before = rows.text(14);
    v.seal = rows.text(15);
    v.is_in_place = rows.integer(16) != 0;
    found.push_back(std::move(v));
  }
  read_frames(found);
  read_progress(found);
  Statement tags(database_, "SELECT name, version FROM tag ORDER BY name");
  while (tags.step()) {
    for (StoredVersion& version : found) {
      if (version.number == tags.integer(1)) version.tags.push_back(tags.text(0));
    }
  }
  return found;
}

/// Whether there is such a table: a history that another evermap began may have none.
bool VersionTable::has_table(const std::string& name) {
  return Statement(database_, "SELECT 1 FROM sqlite_master WHERE name = ?").bind(name).step();
}

void VersionTable::read_progress(std::vector<StoredVersion>& versions) {
  if (!has_table("progress")) return;
  Statement rows(database_, "SELECT version, scans FROM progress");
  while (rows.step()) {
    for (StoredVersion& version : versions) {
      if (version.number == rows.integer(0)) version.cause.scans = static_cast<std::size_t>(rows.integer(1));
    }
  }
}

/// A version has the frame of the last one that was stored as a whole.
void VersionTable::read_frames(std::vector<StoredVersion>& versions) {
  if (!has_table("frame")) return;
  Statement rows(database_,
                 "SELECT version, name, latitude, longitude, altitude FROM frame ORDER BY version");
  bool is_row = rows.step();
  MapFrame frame;
  for (StoredVersion& version : versions) {
    while (is_row && rows.integer(0) < version.number) is_row = rows.step();
    if (version.is_whole) frame = {};
    if (version.is_whole && is_row && rows.integer(0) == version.number) {
      frame.name = rows.text(1);
      if (!rows.is_null(2)) frame.origin = {rows.real(2), rows.real(3), rows.real(4)};
    }
    version.frame = frame;
  }
}

int VersionTable::number_of(const std::string& name) {
  const std::vector<StoredVersion> all = versions();
  for (const StoredVersion& version : all) {
    if (std::to_string(version.number) == name ||
        std::find(version.tags.begin(), version.tags.end(), name) != version.tags.end())
      return version.number;
  }
  const std::string range =
      all.empty() ? "none" : std::to_string(all.front().number) + " to " + std::to_string(all.back().number);
  throw FileError(database_.path(), "holds no version \"" + name.substr(0, 80) + "\"; there are " + range);
}

void VersionTable::for_each_part(const StoredVersion& version,
                                 const std::function<void(std::span<const LeafChange>)>& visit) {
  Statement parts(database_, "SELECT part, data FROM change WHERE version = ? ORDER BY part");
  parts.bind(std::int64_t{version.number});
  std::size_t read = 0;
  while (parts.step()) {
    const auto changes = unpack(parts.blob(1), owner_of("change", version, parts.integer(0)));
    if (!changes) {
      throw FileError(database_.path(), "version " + std::to_string(version.number) + ": part " +
                                            std::to_string(parts.integer(0)) + " is damaged; " + kAdvice);
    }
    read += changes->size();
    visit(*changes);
  }
  if (read == version.written + version.removed) return;
  throw FileError(database_.path(), "version " + std::to_string(version.number) +
                                        ": a part of its changes is missing; " + kAdvice);
}

void VersionTable::apply(const StoredVersion& version, Octree& octree, const VersionVisitor& visit) {
  if (version.is_whole) octree = Octree(version.grid, version.frame);
  for_each_part(version, [&](std::span<const LeafChange> changes) {
    if (visit) visit(version, octree, changes);
    apply_changes(changes, octree);
  });
}

void VersionTable::check(const StoredVersion& version, const Octree& octree) const {
  if (fingerprint_of(octree).hex() == version.fingerprint && seal_of(version) == version.seal) return;
  throw FileError(database_.path(),
                  "version " + std::to_string(version.number) + " is not what was written; " + kAdvice);
}

Octree VersionTable::checkout(int number, const VersionVisitor& visit) {
  const std::vector<StoredVersion> all = versions();
  const auto end =
      std::find_if(all.begin(), all.end(), [&](const StoredVersion& v) { return v.number > number; });
  auto begin = end;
  while (begin != all.begin() && !(--begin)->is_whole) {
  }
  if (begin == end || !begin->is_whole || std::prev(end)->number != number)
    throw FileError(database_.path(), "holds no version " + std::to_string(number));
  Octree octree(begin->grid, begin->frame);
  for (auto version = begin; version != end; ++version) apply(*version, octree, visit);
  check(*std::prev(end), octree);
  return octree;
}

Journal VersionTable::journal() {
  Journal journal;
  Statement run(database_, "SELECT what, parameters FROM run");
  if (run.step()) journal.cause = {run.text(0), run.text(1), 0};
  const std::vector<StoredVersion> all = versions();
  Statement parts(database_, "SELECT part, scans, data FROM journal ORDER BY part");
  while (parts.step()) {
    const auto changes =
        all.empty() ? std::nullopt : unpack(parts.blob(2), owner_of("journal", all.back(), parts.integer(0)));
    if (!changes) {
      throw FileError(database_.path(),
                      "part " + std::to_string(parts.integer(0)) + " of the journal is damaged; " + kAdvice);
    }
    journal.scans = static_cast<std::size_t>(parts.integer(1));
    journal.changes.insert(journal.changes.end(), changes->begin(), changes->end());
  }
  return journal;
}

/// REQUIRES: all but what the changes tell is filled in.
void VersionTable::insert(StoredVersion& version, const std::vector<LeafChange>& changes) {
  version.removed = static_cast<std::size_t>(std::count_if(
      changes.begin(), changes.end(), [](const LeafChange& change) { return change.is_removed(); }));
  version.written = changes.size() - version.removed;
  version.seal = seal_of(version);
  Statement row(database_, "INSERT INTO version VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)");
  row.bind(std::int64_t{version.number})
      .bind(version.time)
      .bind(version.cause.what)
      .bind(version.cause.parameters);
  row.bind(version.evermap).bind(version.fingerprint).bind(version.grid.edge);
  for (int axis = 0; axis < 3; ++axis) row.bind(version.grid.origin[axis]);
  for (const std::size_t count : {version.leaves, version.written, version.removed})
    row.bind(static_cast<std::int64_t>(count));
  row.bind(std::int64_t{version.is_whole}).bind(version.before).bind(version.seal);
  row.bind(std::int64_t{version.is_in_place}).run();
  if (version.is_whole && version.frame != MapFrame{}) {
    Statement frame(database_, version.frame.origin ? "INSERT INTO frame VALUES(?,?,?,?,?)"
                                                    : "INSERT INTO frame VALUES(?,?,NULL,NULL,NULL)");
    frame.bind(std::int64_t{version.number}).bind(version.frame.name);
    if (const auto& origin = version.frame.origin)
      frame.bind(origin->latitude).bind(origin->longitude).bind(origin->altitude);
    frame.run();
  }
  if (version.cause.scans > 0) {
    Statement(database_, "INSERT INTO progress VALUES(?,?)")
        .bind(std::int64_t{version.number})
        .bind(static_cast<std::int64_t>(version.cause.scans))
        .run();
  }
  Statement insert_part(database_, "INSERT INTO change VALUES(?,?,?)");
  std::int64_t part = 0;
  for_each_stretch(changes, [&](std::span<const LeafChange> stretch) {
    const std::string data = pack(stretch, owner_of("change", version, part));
    insert_part.bind(std::int64_t{version.number}).bind(part).bind_blob(data).run();
    ++part;
  });
}

bool VersionTable::has_journal() {
  return is_begun_ && Statement(database_, "SELECT 1 FROM journal LIMIT 1").step();
}

StoredVersion VersionTable::append(const Octree& before, const Octree& after, StoredVersion version) {
  const std::vector<StoredVersion> all = versions();
  const bool is_whole = all.empty() || all.back().grid != after.grid() || all.back().frame != after.frame();
  version.number = all.empty() ? 1 : all.back().number + 1;
  version.time = std::time(nullptr);
  version.evermap = EVERMAP_VERSION;
  version.grid = after.grid();
  version.frame = after.frame();
  version.fingerprint = fingerprint_of(after).hex();
  version.leaves = after.leaf_count();
  version.is_whole = is_whole;
  version.before = all.empty() ? "" : all.back().seal;
  insert(version, changes_between(is_whole ? Octree(after.grid()) : before, after));
  return version;
}

void VersionTable::remove(int number) {
  for (const char* statement :
       {"DELETE FROM version WHERE number = ?", "DELETE FROM change WHERE version = ?",
        "DELETE FROM frame WHERE version = ?", "DELETE FROM progress WHERE version = ?"})
    Statement(database_, statement).bind(std::int64_t{number}).run();
}

void VersionTable::keep_only(const std::vector<bool>& is_kept) {
  const std::vector<StoredVersion> all = versions();
  Transaction transaction(database_);
  std::optional<Octree> kept;  // the last version that stays
  std::string seal;            // of it
  Octree now(VoxelGrid{});
  for (std::size_t i = 0; i < all.size(); ++i) {
    apply(all[i], now);
    if (!is_kept[i]) {
      remove(all[i].number);
      continue;
    }
    StoredVersion version = all[i];
    version.before = seal;
    if (i > 0 && !is_kept[i - 1]) {
      check(all[i], now);
      version.is_whole =
          version.is_whole || !kept || kept->grid() != now.grid() || kept->frame() != now.frame();
      remove(version.number);
      insert(version, changes_between(version.is_whole ? Octree(now.grid()) : *kept, now));
    } else {
      version.seal = seal_of(version);
      Statement(database_, "UPDATE version SET before = ?, seal = ? WHERE number = ?")
          .bind(version.before)
          .bind(version.seal)
          .bind(std::int64_t{version.number})
          .run();
    }
    seal = version.seal;
    kept = now;
  }
  transaction.commit();
  database_.execute("VACUUM");
}

void VersionTable::set_in_place(int number) {
  Statement(database_, "UPDATE version SET is_in_place = 1 WHERE number = ?")
      .bind(std::int64_t{number})
      .run();
}

std::size_t VersionTable::append_to_journal(const StoredVersion& newest, const Octree& before,
                                            const Octree& after, std::size_t scans, const MapCause& cause) {
  const std::vector<LeafChange> changes = changes_between(before, after);
  Transaction transaction(database_);
  const std::size_t bytes = insert_into_journal(newest, changes, scans, cause);
  transaction.commit();
  return bytes;
}

std::size_t VersionTable::condense_journal(const StoredVersion& newest, const Octree& after,
                                           std::size_t scans, const MapCause& cause) {
  const std::vector<LeafChange> changes = changes_between(checkout(newest.number), after);
  Transaction transaction(database_);
  clear_journal();
  const std::size_t bytes = insert_into_journal(newest, changes, scans, cause);
  transaction.commit();
  return bytes;
}

std::size_t VersionTable::insert_into_journal(const StoredVersion& newest,
                                              const std::vector<LeafChange>& changes, std::size_t scans,
                                              const MapCause& cause) {
  std::int64_t part = last_part_of_journal();
  if (part == 0) {
    database_.execute("DELETE FROM run");
    Statement(database_, "INSERT INTO run VALUES(?,?)").bind(cause.what).bind(cause.parameters).run();
  }
  Statement insert(database_, "INSERT INTO journal VALUES(?,?,?)");
  std::size_t bytes = 0;
  for_each_stretch(changes, [&](std::span<const LeafChange> stretch) {
    const std::string data = pack(stretch, owner_of("journal", newest, ++part));
    bytes += data.size();
    insert.bind(part).bind(static_cast<std::int64_t>(scans)).bind_blob(data).run();
  });
  return bytes;
}

/// On its own, so that no statement is open when a transaction ends: SQLite would not empty its log then.
std::int64_t VersionTable::last_part_of_journal() {
  Statement last(database_, "SELECT COALESCE(MAX(part), 0) FROM journal");
  last.step();
  return last.integer(0);
}

void VersionTable::clear_journal() { database_.execute("DELETE FROM journal; DELETE FROM run;"); }

void VersionTable::tag(const std::string& name, int number) {
  Statement(database_, "INSERT OR REPLACE INTO tag VALUES(?,?)").bind(name).bind(std::int64_t{number}).run();
}

}  // namespace evermap
