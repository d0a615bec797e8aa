// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "run.hpp"

namespace evermap {

/// Gives the maintainer all scans with their poses, which are checked, and keeps a journal in `store`. Adds
/// to `cause` how many scans were done and, of a run that was stopped, how many the map has then, `before` of
/// them from a run that this one goes on with.
Run run_journaled(PosedScans& scans, const RunOptions& options, MapMaintainer& maintainer, PoseCheck& check,
                  MapStore& store, const JournalParameters& journal, MapCause& cause, std::size_t before);

}  // namespace evermap
