// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include <evermap/map/map_difference.hpp>
#include <evermap/map/octree.hpp>

namespace evermap {

/// Pictures of two maps from above, north (y) up, all of the same area: before.png and after.png by height,
/// change.png by what became of each leaf; legend.txt says what colours mean. The area leaves out the
/// outermost leaves, so that a few far ones do not shrink the rest. Throws FileError when one cannot be
/// written.
void write_pictures(const std::filesystem::path& folder, const Octree& before, const Octree& after,
                    const MapDifference& difference);

}  // namespace evermap
