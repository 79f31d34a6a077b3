#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Patrols through a plant of collectors as a user does, twice over the same store of findings, and judges
what was found against the truth of the simulation, and how the navigator drove: each row that was asked
for is driven along, around a box that no map shows and past a closed road, and nothing is touched.

    patrol_mission_test.py CASE LAUNCH_SCRIPTS SCRATCH
"""

import os
import pathlib
import re
import shutil
import sqlite3
import sys

from mission import figures, pipescout, recorded

# What runs beside this may use the same domain, but not this namespace.
NAMESPACE = f"/patrol_test_{os.getpid()}"
TIMEOUT = 600  # s, of a run


def run(composition, folder, *arguments):
    return pipescout("run", composition, "--namespace", NAMESPACE, "--out", folder, *arguments, timeout=TIMEOUT)


def check(folder, told):
    # A contact, or a row that is not driven along, ends the run with an error.
    tour = re.search(r"(\d+) rows driven along, (\d+) left out, (\d+) % of their pipes", told)
    assert tour, told
    assert tour.group(1) == "2" and tour.group(2) == "0", tour.group(0)
    assert int(tour.group(3)) >= 95, tour.group(0)
    driven = figures(folder, f"{NAMESPACE[1:]}.navigation")
    assert driven["_command_gap_s"] <= 0.1, driven
    for name in ("plant.yaml", "plant.pgm", "plant.geojson"):
        assert (folder / "map" / name).stat().st_size > 100, name
    found = figures(folder, f"{NAMESPACE[1:]}.leak")
    assert found["s_found_percent"] == 100.0, found
    assert found["s_false"] == 0, found
    assert found["_position_worst_m"] <= 1.0, found
    assert found["_pictures_failed"] == 0, found
    assert len(recorded(folder, "detections.csv")) == found["_pictures"], found
    state = figures(folder, f"{NAMESPACE[1:]}.estimator_")
    assert state["position_rmse_m"] <= 0.6, state
    assert state["restarts"] == 0, state
    assert figures(folder, f"{NAMESPACE[1:]}.arm")["_fault_cycles"] == 0
    assert len(recorded(folder, "track.csv")) == found["_pictures"], found
    for name in ("report.html", "leaks.geojson", "leaks.kml", "leaks.csv"):
        assert (folder / "report" / name).stat().st_size > 100, name


def check_track(folder):
    tracking = figures(folder, f"{NAMESPACE[1:]}.track")
    assert tracking["_in_view_percent"] >= 98.0, tracking  # it leaves its line for what is in its way
    assert tracking["_estimate_position_px"] <= 3.0, tracking
    assert tracking["_lost"] <= 2, tracking  # behind the end of each row


def one_process(launch_scripts, scratch):
    store = scratch / "leaks.db"
    told = run(launch_scripts / "patrol.yaml", scratch / "first", "--param",
               f"leak_inspector.store:={store}")
    check(scratch / "first", told)
    check_track(scratch / "first")
    first = sqlite3.connect(store).execute("SELECT id FROM finding ORDER BY id").fetchall()
    assert first, "no findings in the store"
    # Another day: the same leaks, and no new ones.
    told = run(launch_scripts / "patrol.yaml", scratch / "second", "--param",
               f"leak_inspector.store:={store}")
    check(scratch / "second", told)
    check_track(scratch / "second")
    second = sqlite3.connect(store).execute("SELECT id FROM finding ORDER BY id").fetchall()
    assert second == first, (first, second)
    assert "raised" not in {row["event"] for row in recorded(scratch / "second", "events.csv")}


def several_processes(launch_scripts, scratch):
    """The same composition with each component in a process of its own, over DDS. Within a step, messages
    arrive in any order, so each run is another drive: what is judged is that all of them arrive and that
    the mission is done. How well the track is kept is judged where it is the same in each run."""
    text = (launch_scripts / "patrol.yaml").read_text()
    composition = scratch / "patrol_isolated.yaml"
    composition.write_text(text.replace("  - type:", "  - isolate: true\n    type:"))
    # No faster than messages get from process to process.
    (scratch / "run").mkdir()
    told = run(composition, scratch / "run/mission", "rate:=4.0")
    mission = scratch / "run/mission"
    check(mission, told)
    log = (mission / "mission.log").read_text()
    assert "does not get through with a step" not in log, log[-4000:]
    assert figures(mission, "inputs_lost") == {"": 0}, "inputs were lost"


def main():
    case, launch_scripts, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    {"one_process": one_process,
     "several_processes": several_processes}[case](launch_scripts, scratch)


if __name__ == "__main__":
    main()
