// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <xxhash.h>

#include <evermap/files/detail/input_file.hpp>
#include <evermap/io/detail/atomic_file.hpp>
#include <evermap/io/detail/map_undo.hpp>
#include <evermap/io/map_file.hpp>

namespace evermap {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 20;  // [bytes]

template <class Visit>
void for_each_block(const std::filesystem::path& path, Visit&& visit) {
  InputStream file(path);
  std::string block;
  while (file.rest() > 0) {
    block.clear();
    file.append_to(block, std::min<std::uint64_t>(file.rest(), kBlock));
    visit(block);
  }
}

/// The file behind links, which need not exist.
std::filesystem::path target_of(const std::filesystem::path& map) {
  std::error_code error;
  std::filesystem::path target = std::filesystem::weakly_canonical(map, error);
  if (error) throw FileError(map, "cannot be kept for undo: " + error.message());
  return target;
}

std::filesystem::path with_suffix(std::filesystem::path path, const std::string& suffix) {
  return path += suffix;
}
/// The map as it was when a run began to save, until it has saved.
std::filesystem::path pending_path(const std::filesystem::path& target) {
  return with_suffix(target, ".undo.pending");
}
/// What to bring back for the map that is there now.
std::filesystem::path undo_path(const std::filesystem::path& target) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), XXH3_freeState);
  XXH3_64bits_reset(state.get());
  for_each_block(
      target, [&](const std::string& block) { XXH3_64bits_update(state.get(), block.data(), block.size()); });
  std::array<char, 17> hash{};
  std::snprintf(hash.data(), hash.size(), "%016llx",
                static_cast<unsigned long long>(XXH3_64bits_digest(state.get())));
  return with_suffix(target, std::string(".undo.") + hash.data());
}

std::vector<std::filesystem::path> kept_for(const std::filesystem::path& target) {
  std::vector<std::filesystem::path> kept;
  const std::string prefix = target.filename().string() + ".undo.";
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(target.parent_path(), error)) {
    if (entry.path().filename().string().starts_with(prefix)) kept.push_back(entry.path());
  }
  return kept;
}

void move(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  std::filesystem::rename(from, to, error);
  if (error) throw FileError(to, "cannot be put in place: " + error.message());
  sync_folder_of(to);
}

void keep(const std::filesystem::path& target) {
  const std::filesystem::path pending = pending_path(target);
  std::error_code error;
  std::filesystem::create_hard_link(target, pending, error);
  if (!error) return;
  AtomicFile copy(pending);  // a file system without hard links
  for_each_block(target, [&](const std::string& block) { copy.write(block); });
  copy.commit();
}

/// What was kept belongs to the map that has just been saved.
void publish(const std::filesystem::path& target) {
  const std::filesystem::path undo = undo_path(target);
  move(pending_path(target), undo);
  std::error_code ignored;
  for (const std::filesystem::path& kept : kept_for(target)) {
    if (kept != undo) std::filesystem::remove(kept, ignored);
  }
}

bool are_same(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  if (std::filesystem::equivalent(a, b, error)) return true;
  if (std::filesystem::file_size(a, error) != std::filesystem::file_size(b, error)) return false;
  return InputFile(a).bytes() == InputFile(b).bytes();
}

/// Ends what a run began that was killed: it had saved when the map is no longer what it kept.
void settle(const std::filesystem::path& target) {
  const std::filesystem::path pending = pending_path(target);
  std::error_code error;
  if (!std::filesystem::exists(pending, error)) return;
  if (!std::filesystem::exists(target, error) || are_same(pending, target)) {
    std::filesystem::remove(pending, error);
  } else {
    publish(target);
  }
}

}  // namespace

void save_map_with_undo(const std::filesystem::path& map, const Octree& octree) {
  const std::filesystem::path target = target_of(map);
  std::error_code error;
  settle(target);
  const bool is_replaced = std::filesystem::exists(target, error);
  if (is_replaced) keep(target);
  save_map(map, octree);
  if (is_replaced) settle(target);
}

void undo_map(const std::filesystem::path& map) {
  const std::filesystem::path target = target_of(map);
  settle(target);
  const std::filesystem::path kept = undo_path(target);
  std::error_code error;
  if (!std::filesystem::exists(kept, error)) {
    throw FileError(map, kept_for(target).empty()
                             ? "no map was kept for undo; update and localize keep one with --undo-log"
                             : "the map that was kept is not the one before this: a later run replaced it "
                               "without --undo-log");
  }
  load_map(kept);  // a damaged map must not replace a good one
  move(kept, target);
}

}  // namespace evermap
