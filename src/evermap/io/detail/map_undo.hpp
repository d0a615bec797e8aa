// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/map/octree.hpp>

namespace evermap {

/// save_map(), after which undo_map() brings back the map that was replaced, if there was one. That is kept
/// beside the new one as `map.evm.undo.HASH`, where HASH is of the new map: it is brought back for that map
/// and for no other. What was kept before is dropped. A hard link where the file system has them: no bytes
/// are copied.
///
/// Whenever the process ends, undo_map() brings back the map before the last one that was saved, or says that
/// it cannot. Throws FileError. One writer at a time (MapLock).
void save_map_with_undo(const std::filesystem::path& map, const Octree& octree);

/// Brings back the map before, bit for bit, in one step, and durably. Throws FileError, and changes nothing,
/// when none was kept for the map as it is now, or when what was kept is damaged. One writer at a time
/// (MapLock).
void undo_map(const std::filesystem::path& map);

}  // namespace evermap
