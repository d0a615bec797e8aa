// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <utility>

#include <evermap/files/detail/background.hpp>
#include <evermap/files/file_error.hpp>
#include <evermap/history/background_store.hpp>

namespace evermap {

BackgroundStore::BackgroundStore(MapStore& store, const Octree& map, MapCause cause,
                                 const JournalParameters& journal)
    : store_(store), cause_(std::move(cause)), journal_(journal) {
  store_.begin(map, cause_, journal_);
}

BackgroundStore::~BackgroundStore() { wait(); }

bool BackgroundStore::is_idle() {
  if (task_.valid() && task_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) collect();
  return !task_.valid();
}

void BackgroundStore::wait() {
  if (task_.valid()) collect();
}

void BackgroundStore::collect() {
  try {
    task_.get();
    failure_.clear();
  } catch (const FileError& error) {  // the robot drives on; the next task tries again
    failure_ = error.what();
  }
}

void BackgroundStore::start(std::function<void()> task) { task_ = in_background(std::move(task)); }

void BackgroundStore::acknowledge(const std::function<Octree()>& map, std::size_t scans) {
  if (!is_idle() || !store_.is_due(scans)) return;
  start([this, map = map(), scans] { store_.acknowledge([&] { return map; }, scans); });
}

void BackgroundStore::commit(Octree map, const std::string& what) {
  start([this, map = std::move(map), cause = MapCause{what, cause_.parameters, 0}] {
    store_.commit(map, cause);
    store_.begin(map, cause_, journal_);
  });
}

}  // namespace evermap
