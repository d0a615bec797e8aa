# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
import threading

import numpy as np
import pytest
from conftest import wall

import evermap


def test_a_hole_in_a_wall_goes_from_the_map(wall_map):
    maintainer = evermap.MapMaintainer(wall_map)
    for _ in range(10):
        result = maintainer.update(wall(10.1, hole=True), np.eye(4))
    assert result.is_written and result.is_believed and result.points_used == len(wall(10.1))
    changes = evermap.compare(wall_map, maintainer.map)
    assert len(changes.removed) == 36 and len(changes.added) > 10
    assert np.all(abs(changes.removed[:, 1:]) < 0.7)
    assert np.all(wall_map.claims(changes.removed))
    assert not np.any(maintainer.map.claims(changes.removed))


def test_a_map_is_a_snapshot(wall_map):
    maintainer = evermap.MapMaintainer(wall_map)
    before = maintainer.map.leaves()
    for _ in range(10):
        maintainer.update(wall(10.1, hole=True), np.eye(4))
    assert np.array_equal(before.means, wall_map.leaves().means)


def test_leaves_are_gaussians(wall_map):
    leaves = wall_map.leaves()
    count = len(leaves.counts)
    assert leaves.means.shape == (count, 3) and leaves.covariances.shape == (count, 3, 3)
    assert leaves.log_odds.shape == (count,) and np.all(leaves.log_odds > 0)
    assert np.array_equal(leaves.means, wall_map.surface())
    assert np.allclose(leaves.covariances, leaves.covariances.transpose(0, 2, 1))
    assert np.all(np.linalg.eigvalsh(leaves.covariances) > 0)
    assert np.allclose(leaves.means[:, 0], 10.1, atol=0.01)
    assert len(wall_map.leaves(occupied_only=False).counts) == len(wall_map)


def test_a_map_comes_back_from_its_file(wall_map, tmp_path):
    wall_map.save(tmp_path / "wall.evm")
    again = evermap.Map.load(tmp_path / "wall.evm")
    assert again.resolution == wall_map.resolution and len(again) == len(wall_map)
    assert all(np.array_equal(a, b) for a, b in zip(again.leaves(), wall_map.leaves()))
    wall_map.save(str(tmp_path / "text.evm"))
    assert (tmp_path / "text.evm").read_bytes() == (tmp_path / "wall.evm").read_bytes()


def test_files_that_cannot_be_right_are_named(tmp_path):
    with pytest.raises(evermap.FileError, match="none.evm"):
        evermap.Map.load(tmp_path / "none.evm")
    (tmp_path / "bad.evm").write_bytes(b"no map")
    with pytest.raises(evermap.FileError, match="is no evermap map"):
        evermap.Map.load(tmp_path / "bad.evm")
    with pytest.raises(evermap.FileError, match="no_folder"):
        evermap.Map(0.2).save(tmp_path / "no_folder" / "map.evm")


def test_what_comes_in_is_checked(wall_map):
    points = wall(10.1)
    maintainer = evermap.MapMaintainer(wall_map)
    for bad, error, words in [(points[:, :2], ValueError, r"shape \(\d+, 2\)"), (points.ravel(), ValueError, "shape"),
                              (points.astype(complex), TypeError, "complex128"), ([["a", "b", "c"]], TypeError, "not real"),
                              (None, TypeError, "not real numbers"), ([[1, 2], [3]], TypeError, "")]:
        with pytest.raises(error, match=words):
            maintainer.update(bad, np.eye(4))
    for bad in (np.eye(3), 2 * np.eye(4), np.full((4, 4), np.nan), np.diag([1.0, 1, -1, 1])):
        with pytest.raises(ValueError, match="pose"):
            maintainer.update(points, bad)
    for bad in (0, -1, 100, float("nan")):
        with pytest.raises(ValueError, match="resolution"):
            evermap.Map(bad)
    with pytest.raises(ValueError, match="mode"):
        evermap.MapMaintainer(wall_map, mode="magic")
    with pytest.raises(ValueError, match="grids"):
        evermap.compare(wall_map, evermap.Map(0.4))


def test_any_real_numbers_of_any_layout_are_the_same(wall_map):
    points = np.round(wall(10.1, hole=True), 2).astype(np.float32)
    expected = None
    locked = points.astype(np.float64)
    locked.setflags(write=False)
    for same in (points, points.astype(np.float64), np.asfortranarray(points), points[::-1][::-1], locked,
                 points.tolist()):
        maintainer = evermap.MapMaintainer(wall_map)
        maintainer.update(same, np.eye(4))
        leaves = maintainer.map.leaves()
        expected = expected or leaves
        assert np.allclose(leaves.means, expected.means, atol=1e-6)


def test_points_that_are_none_are_left_out_and_counted():
    points = wall(10.1)
    points[3] = np.nan
    points[7, 1] = np.inf
    points[11] = 0
    scan = evermap.Scan(points, point_times=np.linspace(0, 0.1, len(points)), time=5.0)
    assert len(scan) == len(points) - 3 and scan.points.shape == (len(scan), 3)
    assert (scan.dropped_not_finite, scan.dropped_at_origin) == (2, 1)
    assert scan.point_times.shape == (len(scan),) and scan.time == 5.0
    assert not scan.points.flags.writeable
    with pytest.raises(ValueError, match="one for each point"):
        evermap.Scan(points, point_times=[0.0])


def test_the_view_of_a_scans_points_outlives_the_scan():
    points = evermap.Scan(wall(10.1)).points
    assert np.allclose(points, wall(10.1))


def test_readers_see_whole_maps_while_scans_are_taken(wall_map):
    maintainer = evermap.MapMaintainer(wall_map, threads=1)
    sizes, done = [], threading.Event()

    def read():
        while not done.is_set():
            sizes.append(len(maintainer.map.surface()))

    reader = threading.Thread(target=read)
    reader.start()
    for i in range(30):
        maintainer.update(wall(10.1, hole=i % 2 == 1), np.eye(4))
    done.set()
    reader.join()
    assert len(sizes) > 1 and min(sizes) > 0.5 * len(wall_map.surface())


def test_any_number_of_threads_gives_the_same_map(yard):
    maps = []
    for threads in (1, 2, 3):
        maintainer = evermap.MapMaintainer(evermap.Map.from_cloud(yard.survey(0.2), 0.4), threads=threads)
        for i in range(4):
            maintainer.update(yard.scan(i), yard.pose(i))
        maps.append(maintainer.map.leaves())
    for leaves in maps[1:]:
        assert all(np.array_equal(a, b) for a, b in zip(leaves, maps[0]))


def test_parameters_are_text_and_back(tmp_path):
    parameters = evermap.Parameters()
    parameters.lidar.max_range = 55
    (tmp_path / "p.yaml").write_text(str(parameters))
    assert str(evermap.Parameters.read(tmp_path / "p.yaml")) == str(parameters)
    assert "55" in str(parameters) and str(evermap.Parameters.paper()) != str(evermap.Parameters())
    (tmp_path / "bad.yaml").write_text("lidar: {reach: 3}\n")
    with pytest.raises(evermap.FileError, match="line 1"):
        evermap.Parameters.read(tmp_path / "bad.yaml")
