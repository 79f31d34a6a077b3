#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Patrols along collectors as a user does, twice over the same store of findings, and judges what was
found against the truth of the simulation.

    patrol_mission_test.py CASE LAUNCH_SCRIPTS SCRATCH
"""

import os
import pathlib
import shutil
import sqlite3
import sys

from mission import figures, pipescout, recorded

# What runs beside this may use the same domain, but not this namespace.
NAMESPACE = f"/patrol_test_{os.getpid()}"
TIMEOUT = 600  # s, of a run


def run(composition, folder, *arguments):
    # Simulated time is everybody's in a domain, unless the topic is the mission's own.
    text = composition.read_text()
    own = folder.parent / composition.name
    own.write_text(text.replace("    parameters:", "    remappings: {/clock: clock}\n"
                                                   "    parameters:"))
    pipescout("run", own, "--namespace", NAMESPACE, "--out", folder, *arguments, timeout=TIMEOUT)


def check(folder):
    found = figures(folder, f"{NAMESPACE[1:]}.leak")
    assert found["s_found_percent"] == 100.0, found
    assert found["s_false"] == 0, found
    assert found["_position_worst_m"] <= 1.0, found
    assert found["_pictures_failed"] == 0, found
    assert len(recorded(folder, "detections.csv")) == found["_pictures"], found
    state = figures(folder, f"{NAMESPACE[1:]}.estimator_")
    assert state["position_rmse_m"] <= 0.6, state
    assert state["restarts"] == 0, state
    tracking = figures(folder, f"{NAMESPACE[1:]}.track")
    assert tracking["_in_view_percent"] >= 99.0, tracking
    assert tracking["_estimate_position_px"] <= 3.0, tracking
    assert tracking["_lost"] <= 1, tracking  # behind the end of the row
    assert figures(folder, f"{NAMESPACE[1:]}.arm")["_fault_cycles"] == 0
    assert len(recorded(folder, "track.csv")) == found["_pictures"], found
    for name in ("report.html", "leaks.geojson", "leaks.kml", "leaks.csv"):
        assert (folder / "report" / name).stat().st_size > 100, name


def one_process(launch_scripts, scratch):
    store = scratch / "leaks.db"
    run(launch_scripts / "patrol.yaml", scratch / "first", "--param",
        f"leak_inspector.store:={store}")
    check(scratch / "first")
    first = sqlite3.connect(store).execute("SELECT id FROM finding ORDER BY id").fetchall()
    assert first, "no findings in the store"
    # Another day: the same leaks, and no new ones.
    run(launch_scripts / "patrol.yaml", scratch / "second", "--param",
        f"leak_inspector.store:={store}")
    check(scratch / "second")
    second = sqlite3.connect(store).execute("SELECT id FROM finding ORDER BY id").fetchall()
    assert second == first, (first, second)
    assert "raised" not in {row["event"] for row in recorded(scratch / "second", "events.csv")}


def several_processes(launch_scripts, scratch):
    """The same composition with each component in a process of its own, over DDS."""
    text = (launch_scripts / "patrol.yaml").read_text()
    composition = scratch / "patrol_isolated.yaml"
    composition.write_text(text.replace("  - type:", "  - isolate: true\n    type:"))
    # No faster than messages get from process to process.
    (scratch / "run").mkdir()
    run(composition, scratch / "run/mission", "rate:=4.0")
    check(scratch / "run/mission")


def main():
    case, launch_scripts, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    {"one_process": one_process,
     "several_processes": several_processes}[case](launch_scripts, scratch)


if __name__ == "__main__":
    main()
