# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
import numpy as np
import pytest

import evermap


def wall(distance, hole=False):
    """A wall 4 m x 2 m ahead of the sensor, and what is seen through a hole in it 5 m behind."""
    y, z = np.meshgrid(np.arange(-2, 2, 0.04), np.arange(-1, 1, 0.04))
    points = np.stack([np.full_like(y, distance), y, z], axis=-1).reshape(-1, 3)
    if hole:
        points[(abs(points[:, 1]) < 0.6) & (abs(points[:, 2]) < 0.6)] *= 1.5
    return points


@pytest.fixture
def wall_map():
    maintainer = evermap.MapMaintainer(evermap.Map(0.2), mode="mapping")
    for _ in range(5):
        maintainer.update(wall(10.1), np.eye(4))
    return maintainer.map


@pytest.fixture(scope="session")
def yard():
    return evermap.simulate("yard", scans=12)
