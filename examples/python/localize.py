#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""Localizes a robot in a map that is out of date, keeps the map meanwhile, and draws the way and its error."""
import sys

import matplotlib.pyplot as plt
import numpy as np

import evermap


def locate_all(drive, maintainer):
    """The pose of each scan, and whether it is believed. The first scans are believed once the motion is known."""
    results = {}
    for i in range(len(drive)):
        result = maintainer.process(drive.scan(i), drive.time(i))
        for each in [*result.confirmed, result]:
            results[round(each.time, 3)] = each
    return list(results.values())


def main():
    drive = evermap.simulate("yard", scans=15 if "--quick" in sys.argv else 60)
    survey = evermap.Map.from_cloud(drive.survey(), 0.4)
    maintainer = evermap.MapMaintainer(survey, initial_pose=drive.pose(0))
    results = locate_all(drive, maintainer)
    truth = np.array([drive.pose(i) for i in range(len(drive))])
    found = np.array([result.pose for result in results])
    error = evermap.TrajectoryError(truth, found)
    believed = sum(result.is_believed for result in results)
    print(f"{believed} of {len(drive)} scans believed; {1000 * error.rmse:.1f} mm rms, {1000 * error.max:.1f} mm at most")

    figure, (above, over_time) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
    above.scatter(*maintainer.map.surface().T[:2], s=1, color="#C4CAD0")
    above.plot(truth[:, 0, 3], truth[:, 1, 3], color="black", linewidth=3, label="true")
    above.plot(found[:, 0, 3], found[:, 1, 3], color="#0072B2", label="found")
    above.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="The way")
    above.legend()
    over_time.plot(1000 * np.linalg.norm(found[:, :3, 3] - truth[:, :3, 3], axis=1), color="#0072B2")
    over_time.set(xlabel="scan", ylabel="error [mm]", title="Error of the position")
    figure.savefig("trajectory.png", dpi=120)
    print("trajectory.png")


if __name__ == "__main__":
    main()
