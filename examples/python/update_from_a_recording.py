#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""Brings a map up to date from a recording, and draws what changed.

update_from_a_recording.py MAP.evm BAG POSES     POSES: a topic or a frame of the bag, or a file (TUM)
update_from_a_recording.py                       on a simulated yard, for want of a recording
"""
import sys

import matplotlib.pyplot as plt
import numpy as np

import evermap


def recorded(bag, poses):
    """Scans and poses of a bag."""
    try:
        times, matrices = evermap.read_poses(poses)
    except evermap.FileError:  # no file: a topic, or a frame of /tf
        for scan in evermap.open_scans(bag, poses=poses):
            if scan.pose is not None:
                yield scan, scan.pose
        return
    for scan in evermap.open_scans(bag):
        nearest = np.argmin(abs(times - scan.time))
        if abs(times[nearest] - scan.time) < 0.05:
            yield scan, matrices[nearest]


def simulated(count):
    drive = evermap.simulate("yard")
    return evermap.Map.from_cloud(drive.survey(), 0.4), ((drive.scan(i), drive.pose(i)) for i in range(count))


def draw(changes, surface, file):
    figure, axes = plt.subplots(figsize=(7, 6), layout="constrained")
    axes.scatter(*surface.T[:2], s=1, color="#C4CAD0", label=f"{len(surface)} leaves of surface")
    axes.scatter(*changes.removed.T[:2], s=6, color="#D55E00", label=f"{len(changes.removed)} went")
    axes.scatter(*changes.added.T[:2], s=6, color="#0072B2", label=f"{len(changes.added)} came")
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="What changed")
    axes.legend(loc="upper right")
    figure.savefig(file, dpi=120)


def main():
    arguments = [a for a in sys.argv[1:] if a != "--quick"]
    if len(arguments) == 3:
        before, scans = evermap.Map.load(arguments[0]), recorded(*arguments[1:])
    else:
        before, scans = simulated(count=12 if "--quick" in sys.argv else 60)
    maintainer = evermap.MapMaintainer(before)
    for scan, pose in scans:
        maintainer.update(scan, pose)
    changes = evermap.compare(before, maintainer.map)
    print(f"{len(changes.added)} leaves came, {len(changes.removed)} went, {len(changes.moved)} moved")
    maintainer.map.save("updated.evm")
    draw(changes, maintainer.map.surface(), "changes.png")
    print("updated.evm, changes.png")


if __name__ == "__main__":
    main()
