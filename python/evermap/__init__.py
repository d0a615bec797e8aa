# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""evermap: keeps a 3D LiDAR localization map true while the world changes.

Arrays are NumPy's; points are (N, 3) in metres, poses (4, 4), times in seconds.
"""
from collections import namedtuple as _namedtuple

from . import _evermap
from ._evermap import (Drive, FileError, LidarParameters, Map, MapMaintainer, Parameters, Scan, ScanResult, Scans,
                       SurfaceComparison, TrajectoryError, __version__, open_scans, read_cloud, read_poses, simulate,
                       write_poses)
from .scoring import EvermapMapper, score

__all__ = ["Drive", "EvermapMapper", "FileError", "Leaves", "LidarParameters", "Map", "MapDifference", "MapMaintainer",
           "Parameters", "Scan", "ScanResult", "Scans", "SurfaceComparison", "TrajectoryError", "__version__", "compare",
           "open_scans", "read_cloud", "read_poses", "score", "simulate", "write_poses"]

Leaves = _namedtuple("Leaves", "means covariances counts log_odds")
Leaves.__doc__ = "Leaves of a map: means (N, 3) [m], covariances (N, 3, 3) [m^2], counts (N,) of points, log_odds (N,)."

MapDifference = _namedtuple("MapDifference", "added removed moved")
MapDifference.__doc__ = "Means (N, 3) [m] of occupied leaves that came, went, or whose surface moved within its voxel."


def _leaves(self, occupied_only=True):
    """The leaves as Leaves; with occupied_only=False pending ones, too, whose log_odds are not above 0."""
    return Leaves(*self._leaves(occupied_only))


Map.leaves = _leaves


def compare(before, after):
    """What changed from one Map to another of the same grid, as MapDifference. Raises ValueError."""
    return MapDifference(*_evermap._compare(before, after))
