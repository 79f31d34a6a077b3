#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Passes a hot vessel as a user does, and judges the track by the geometry of the simulated world.

    vessel_mission_test.py SHAPE LAUNCH_SCRIPTS SCRATCH
"""

import math
import os
import pathlib
import shutil
import statistics
import sys

from mission import figures, pipescout, recorded

# What runs beside this may use the same domain, but not this namespace.
NAMESPACE = f"/vessel_test_{os.getpid()}"
TIMEOUT = 600  # s, of a run
FOCAL_LENGTH = 722.0  # px
DISTANCE = 14.6  # m, of the vessel's axis from the camera's path
WIDTH, HEIGHT = 1.2, 1.5  # m


def run(composition, folder, *arguments):
    pipescout("run", composition, "--namespace", NAMESPACE, "--out", folder, *arguments, timeout=TIMEOUT)


def is_near(value, wanted, share):
    assert abs(value - wanted) < share * wanted, (value, wanted)


def main():
    shape, launch_scripts, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    arguments = [f"shape:={shape}"]
    if shape == "valve":  # the outline of the vessel is no circle
        arguments += ["--param", "thermal_tracker.region.least_fill:=0.6"]
    run(launch_scripts / "vessel.yaml", scratch / "mission", *arguments)
    found = figures(scratch / "mission", f"{NAMESPACE[1:]}.track")
    assert found["s"] == 1, found
    locked = [row for row in recorded(scratch / "mission", "track.csv") if row["state"] == "locked"]
    # It is whole in the image over 5.2 m of the way, at 1 m/s and 10 Hz.
    assert 40 <= len(locked) <= 60, len(locked)
    width, height = (FOCAL_LENGTH * size / DISTANCE for size in (WIDTH, HEIGHT))
    length = statistics.median(float(row["length"]) for row in locked)
    half_width = statistics.median(float(row["half_width"]) for row in locked)
    if shape == "vessel":
        is_near(length, height, 0.08)
        is_near(half_width, width / 2, 0.08)
        assert all(abs(math.cos(float(row["angle"]))) < 0.15 for row in locked)  # upright
    else:
        is_near(half_width, math.sqrt(width * height / math.pi), 0.08)
        is_near(length, 2 * half_width, 0.01)
    # It goes by from right to left.
    first, last = locked[3], locked[-1]
    seconds = float(last["stamp"]) - float(first["stamp"])
    is_near((float(first["u"]) - float(last["u"])) / seconds, FOCAL_LENGTH / DISTANCE, 0.08)
    assert float(first["u"]) > 220 and float(last["u"]) < 100, (first, last)


if __name__ == "__main__":
    main()
