// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include "journaled_run.hpp"

#include <fmt/format.h>

namespace evermap {

Run run_journaled(PosedScans& scans, const RunOptions& options, MapMaintainer& maintainer, PoseCheck& check,
                  MapStore& store, const JournalParameters& journal, MapCause& cause, std::size_t before) {
  store.begin(maintainer.map(), cause, journal);
  const LookAtScan look_at_poses = check_poses(check, options);
  std::size_t taken = before;
  Run run =
      run_over(scans, options.threads, maintainer, [&](const PosedScan& posed, const ScanResult& result) {
        look_at_poses(posed, result);
        taken = posed.index + 1;
        acknowledge(
            store, [&] { return maintainer.map(); }, taken);
      });
  cause.what += fmt::format(", {} scans", run.scans_done);
  if (run.stopped_by != 0) cause.scans = taken;
  return run;
}

}  // namespace evermap
