# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""Scores a way to keep a map, evermap's or one's own, by the experiments' metrics.

A mapper is any object with

    start(survey)         makes the map of a survey, points (N, 3) [m]
    update(scan, pose)    takes a Scan and its pose (4, 4)
    surface()             (N, 3) [m], one point for each leaf or voxel of surface
    claims(points)        (N,) bool: whether the map shows surface at points (N, 3) [m]
"""
import numpy as np

from ._evermap import Map, MapMaintainer, Parameters, SurfaceComparison


class EvermapMapper:
    """evermap itself, at given poses."""

    def __init__(self, resolution, parameters=None, mode="maintenance"):
        self.resolution, self.parameters, self.mode = resolution, parameters or Parameters(), mode

    def start(self, survey):
        self.maintainer = MapMaintainer(Map.from_cloud(survey, self.resolution), self.parameters, mode=self.mode)

    def update(self, scan, pose):
        self.maintainer.update(scan, pose)

    def surface(self):
        return self.maintainer.map.surface()

    def claims(self, points):
        return self.maintainer.map.claims(points)


def score(mapper, drive, resolution, survey_spacing=0.1):
    """Lets a mapper keep the survey's map over a Drive, and measures it at the end.

    SA: fraction of the unchanged surface that the map kept. DA: fraction of the removed surface that it erased.
    COV, ACC: fraction of the true surface within 0.2 m of the map, and of the map within 0.2 m of the true surface.
    AHD [m]: the larger of the two mean distances. nan where there is nothing to measure on. Returns a dict.
    """
    mapper.start(drive.survey(survey_spacing))
    for i in range(len(drive)):
        mapper.update(drive.scan(i), drive.pose(i))
    unchanged, removed = drive.changes(resolution)

    def claimed(points):
        return float(np.mean(mapper.claims(points))) if len(points) else float("nan")

    surface = SurfaceComparison(drive.truth(len(drive) - 1), mapper.surface())
    return {"SA": claimed(unchanged), "DA": 1 - claimed(removed), "COV 0.2": surface.coverage(0.2),
            "ACC 0.2": surface.accuracy(0.2), "AHD": surface.average_hausdorff_distance}
