#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""A mapper of one's own, scored beside evermap by the experiments' metrics."""
import sys

import numpy as np

import evermap

RESOLUTION = 0.4  # [m]


class HitCounter:
    """Voxels that the last scans hit. What is out of their sight is forgotten: simple, and wrong in its own way."""

    def __init__(self, edge, memory=10):
        self.edge, self.memory, self.scans = edge, memory, 0

    def voxels(self, points):
        return map(tuple, np.floor(np.asarray(points) / self.edge).astype(int))

    def start(self, survey):
        self.last_hit = {voxel: 0 for voxel in self.voxels(survey)}

    def update(self, scan, pose):
        self.scans += 1
        self.last_hit |= {v: self.scans for v in self.voxels(scan.points @ pose[:3, :3].T + pose[:3, 3])}

    def shown(self):
        return {voxel for voxel, scan in self.last_hit.items() if scan > self.scans - self.memory}

    def surface(self):
        return (np.array(sorted(self.shown())) + 0.5) * self.edge

    def claims(self, points):
        shown = self.shown()
        return np.array([voxel in shown for voxel in self.voxels(points)])


def main():
    drive = evermap.simulate("yard", scans=12 if "--quick" in sys.argv else 60)
    mappers = {"evermap": evermap.EvermapMapper(RESOLUTION), "hit counter": HitCounter(RESOLUTION)}
    for name, mapper in mappers.items():
        scores = evermap.score(mapper, drive, RESOLUTION)
        print(f"{name:12}", "  ".join(f"{metric} {value:.3f}" for metric, value in scores.items()))


if __name__ == "__main__":
    main()
