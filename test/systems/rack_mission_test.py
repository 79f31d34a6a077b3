#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Flies over the rack as a user does: images, pose and commands go over topics, and the loop is
closed through them. Judges what was recorded against the truth of the simulation.

    rack_mission_test.py CASE LAUNCH_SCRIPTS SCRATCH
"""

import os
import pathlib
import re
import shutil
import sys

from mission import figures, pipescout, recorded

# What runs beside this may use the same domain, but not this namespace.
NAMESPACE = f"/rack_test_{os.getpid()}"
TIMEOUT = 600  # s, of a run
FOUND_BY_LEVEL = 15.0  # s, from the start: the first pose
OFFSETS_FOUND = 3.0  # s, from the first pose


def run(composition, folder, *arguments):
    pipescout("run", composition, "--namespace", NAMESPACE, "--out", folder, *arguments, timeout=TIMEOUT)


def tracked_since(folder):
    """What was said of each image from the first pose on, which must not be long in coming."""
    images = recorded(folder, "rack/state.csv")
    begin = float(images[0]["stamp"])
    first = next(i for i, row in enumerate(images) if row["status"] == "tracking")
    assert float(images[first]["stamp"]) < begin + FOUND_BY_LEVEL, images[first]
    return images[first:]


def check(folder):
    found = figures(folder, f"{NAMESPACE[1:]}.rack_")
    assert found["way_points_done"] == found["way_points"] == 4, found
    assert found["losses"] == 0, found
    # It starts 5 cm beside where it says it does, over pipes that lie 15 mm beside where the file has
    # them: until their offsets are found, an image now and then does not bear out the pose.
    images = tracked_since(folder)
    begin = float(images[0]["stamp"])
    untracked = [row for row in images if row["status"] != "tracking"]
    late = [row for row in untracked if float(row["stamp"]) > begin + OFFSETS_FOUND]
    assert not late, late
    assert len(untracked) <= 0.05 * len(images), untracked
    assert found["position_median_m"] <= 0.01, found
    assert found["orientation_median_deg"] <= 0.3, found
    # Where the pipes really lie, and not where the rack file has them.
    true_offsets = {"P2": 0.012, "P3": -0.008, "P4": 0.015}
    last = {row["pipe"]: float(row["offset"]) for row in recorded(folder, "offsets.csv")}
    for pipe, offset in true_offsets.items():
        assert abs(last[pipe] - offset) < 0.005, (pipe, last)
    leaks = figures(folder, f"{NAMESPACE[1:]}.leak")
    assert leaks["s_found_percent"] == 100.0, leaks
    assert leaks["s_false"] == 0, leaks
    assert leaks["_position_worst_m"] <= 0.10, leaks
    assert leaks["_pictures_failed"] == 0, leaks
    assert {row["state"] for row in recorded(folder, "leaks/events.csv")} >= {"raised"}
    state = figures(folder, f"{NAMESPACE[1:]}.estimator_")
    assert state["position_rmse_m"] <= 0.03, state
    assert state["orientation_rmse_deg"] <= 1.0, state
    assert state["restarts"] == 0, state


def check_pictures(folder):
    drawn = pipescout("plot", "rack", folder, timeout=TIMEOUT).split()
    names = {pathlib.Path(line).name for line in drawn if line.startswith(str(folder))}
    assert names == {"flight.svg", "pose_errors.svg", "offsets.svg", "overlay.svg", "map.svg",
                     "animation.gif"}, drawn
    assert (folder / "pictures/animation.gif").stat().st_size <= 3_000_000


def one_process(launch_scripts, scratch):
    run(launch_scripts / "rack.yaml", scratch / "mission")
    check(scratch / "mission")
    check_pictures(scratch / "mission")


def several_processes(launch_scripts, scratch):
    """The same composition with each component in a process of its own, over DDS."""
    text = (launch_scripts / "rack.yaml").read_text()
    composition = scratch / "rack_isolated.yaml"
    composition.write_text(text.replace("  - type:", "  - isolate: true\n    type:"))
    (scratch / "run").mkdir()
    run(composition, scratch / "run/mission")
    check(scratch / "run/mission")


def tilted_start(launch_scripts, scratch):
    """Over this rack the wind tilts the camera so that the first image does not bear out a level
    start; a later one does, once the state estimator has told the tilt."""
    text = (launch_scripts / "rack.yaml").read_text()
    composition = scratch / "rack_one_way_point.yaml"
    composition.write_text(re.sub(r"way_points: \[(.*?),\n.*?\]", r"way_points: [\1]", text,
                                  flags=re.DOTALL))
    (scratch / "run").mkdir()
    folder = scratch / "run/mission"
    run(composition, folder, "seed:=8")
    first = recorded(folder, "rack/state.csv")[0]
    assert first["status"] != "tracking", "this seed no longer needs the tilt: take another"
    tracked_since(folder)
    found = figures(folder, f"{NAMESPACE[1:]}.rack_")
    assert found["way_points_done"] == found["way_points"] == 1, found
    assert found["losses"] == 0, found
    assert found["position_median_m"] <= 0.03, found


def main():
    case, launch_scripts, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    {"one_process": one_process, "several_processes": several_processes,
     "tilted_start": tilted_start}[case](launch_scripts, scratch)


if __name__ == "__main__":
    main()
