# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
import re
from pathlib import Path

import numpy as np
import pytest

import evermap


def localized(yard, survey_map, **options):
    maintainer = evermap.MapMaintainer(survey_map, initial_pose=yard.pose(0), **options)
    results = []
    for i in range(len(yard)):
        results.append(maintainer.process(yard.scan(i), yard.time(i)))
        for earlier in results[-1].confirmed:
            results[[round(r.time, 6) for r in results].index(round(earlier.time, 6))] = earlier
    return maintainer, results


def test_a_robot_finds_its_way_and_keeps_the_map(yard):
    survey_map = evermap.Map.from_cloud(yard.survey(0.1), 0.4)
    maintainer, results = localized(yard, survey_map)
    assert maintainer.state == "tracking" and all(r.is_believed for r in results)
    error = evermap.TrajectoryError([yard.pose(i) for i in range(len(yard))], [r.pose for r in results])
    assert error.rmse < 0.01 and error.max < 0.03 and error.rotation_rmse < 0.002 and error.fraction_lost == 0
    assert results[-1].covariance.shape == (6, 6) and np.all(np.linalg.eigvalsh(results[-1].covariance) >= 0)
    assert 0.5 < results[-1].inlier_fraction <= 1
    assert len(evermap.compare(survey_map, maintainer.map).removed) > 10


def test_localization_alone_changes_nothing_and_another_place_is_not_believed(yard):
    survey_map = evermap.Map.from_cloud(yard.survey(0.2), 0.4)
    maintainer, _ = localized(yard, survey_map, mode="localization")
    assert all(np.array_equal(a, b) for a, b in zip(maintainer.map.leaves(), survey_map.leaves()))
    elsewhere = evermap.MapMaintainer(evermap.Map.from_cloud(np.random.default_rng(1).uniform(-20, 20, (20000, 3)), 0.4))
    results = [elsewhere.process(yard.scan(i), yard.time(i)) for i in range(6)]
    assert not any(r.is_believed or r.is_written for r in results) and results[-1].reject_reason


def test_a_scan_that_is_not_later_is_refused(yard):
    maintainer = evermap.MapMaintainer(evermap.Map(0.4))
    maintainer.process(yard.scan(0), 1.0)
    result = maintainer.process(yard.scan(1), 1.0)
    assert not result.is_believed and "not later" in result.reject_reason


def test_scans_are_read_from_folders_with_their_order_and_part(tmp_path, yard):
    for i in range(12):
        yard.scan(i).points.astype(np.float32).tofile(tmp_path / f"{i}.bin")
    (tmp_path / "odd").mkdir()
    scans = evermap.open_scans(tmp_path, format=".bin")
    assert len(scans) == 12
    sizes = [len(scan) for scan in evermap.open_scans(tmp_path, every=5)]
    assert len(sizes) == 3
    with pytest.raises(evermap.FileError, match="none"):
        evermap.open_scans(tmp_path / "none")
    with pytest.raises(ValueError, match="every"):
        evermap.open_scans(tmp_path, every=0)


def test_poses_come_back_from_their_file(tmp_path, yard):
    poses = [yard.pose(i) for i in range(len(yard))]
    times = [yard.time(i) for i in range(len(yard))]
    evermap.write_poses(tmp_path / "poses.txt", times, poses)
    read_times, read = evermap.read_poses(tmp_path / "poses.txt")
    assert np.allclose(read_times, times) and np.allclose(read, poses, atol=1e-6)
    np.savetxt(tmp_path / "kitti.txt", np.reshape(poses, (-1, 16))[:, :12])
    assert evermap.read_poses(tmp_path / "kitti.txt")[0] is None
    with pytest.raises(ValueError, match="1 times for 12 poses"):
        evermap.write_poses(tmp_path / "poses.txt", [1.0], poses)
    with pytest.raises(evermap.FileError, match="none.txt"):
        evermap.read_poses(tmp_path / "none.txt")


class Voxels:
    """A mapper of one's own: voxels of points that were ever seen."""

    def __init__(self, edge):
        self.edge = edge

    def start(self, survey):
        self.seen = {tuple(v) for v in np.floor(survey / self.edge).astype(int)}

    def update(self, scan, pose):
        points = scan.points @ pose[:3, :3].T + pose[:3, 3]
        self.seen |= {tuple(v) for v in np.floor(points / self.edge).astype(int)}

    def surface(self):
        return (np.array(sorted(self.seen)) + 0.5) * self.edge

    def claims(self, points):
        return np.array([tuple(v) in self.seen for v in np.floor(points / self.edge).astype(int)])


def test_ones_own_mapper_is_scored_beside_evermap(yard):
    own = evermap.score(Voxels(0.4), yard, 0.4)
    ours = evermap.score(evermap.EvermapMapper(0.4), yard, 0.4)
    still = evermap.score(evermap.EvermapMapper(0.4, mode="mapping"), yard, 0.4)
    assert own["SA"] > 0.999 and own["DA"] < 0.1 and still["DA"] < 0.1
    assert ours["SA"] > 0.99 and ours["DA"] > 0.5 and ours["ACC 0.2"] > own["ACC 0.2"]
    assert set(own) == {"SA", "DA", "COV 0.2", "ACC 0.2", "AHD"}


def test_the_simulator_repeats_itself_and_names_what_it_does_not_know(yard):
    again = evermap.simulate("yard", scans=12)
    assert np.array_equal(again.scan(3).points, yard.scan(3).points)
    assert not np.array_equal(evermap.simulate("yard", scans=12, seed=7).scan(3).points, yard.scan(3).points)
    with pytest.raises(IndexError):
        yard.scan(12)
    with pytest.raises(evermap.FileError, match="atlantis"):
        evermap.simulate("atlantis")


def test_the_stub_names_all_there_is():
    stub = (Path(evermap.__file__).parent / "__init__.pyi").read_text()
    for name in evermap.__all__:
        assert re.search(rf"^(class {name}\b|def {name}\(|{name}\b)", stub, re.MULTILINE), name
        of_class = getattr(evermap, name)
        if not isinstance(of_class, type) or of_class.__module__ != "evermap._evermap":
            continue
        body = re.search(rf"^class {name}\b.*?(?=^\S|\Z)", stub, re.MULTILINE | re.DOTALL).group()
        for member in vars(of_class):
            if not member.startswith("_") and not issubclass(of_class, Exception):
                assert re.search(rf"\b{member}\b", body), f"{name}.{member}"


def test_all_has_docstrings():
    for name in evermap.__all__:
        assert name == "__version__" or getattr(evermap, name).__doc__, name


def test_an_orientation_is_a_rotation(yard):
    maintainer = evermap.MapMaintainer(evermap.Map.from_cloud(yard.survey(0.1), 0.4), initial_pose=yard.pose(0))
    for wrong in [np.eye(4), 2 * np.eye(3), np.full((3, 3), np.nan)]:
        with pytest.raises(ValueError, match="orientation"):
            maintainer.process(yard.scan(0), yard.time(0), orientation=wrong)
    assert maintainer.process(yard.scan(0), yard.time(0), orientation=np.eye(3)).inlier_fraction > 0.5
