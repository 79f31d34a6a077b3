#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the crawler mission as a user does, and judges what it left behind against the truth of the
simulation.

    crawler_mission_test.py CASE LAUNCH_SCRIPTS SCRATCH
"""

import csv
import math
import os
import pathlib
import shutil
import sys

from mission import expect_healthy, figures, pipescout, recorded

# What runs beside this may use the same domain, but not this namespace.
NAMESPACE = f"/crawler_test_{os.getpid()}"
TIMEOUT = 600  # s, of a run


def run(composition, folder, *arguments):
    expect_healthy(pipescout("run", composition, "--namespace", NAMESPACE, "--out", folder,
                             "--param", "crawler_simulation.length:=300.0", *arguments, timeout=TIMEOUT))


def check(folder, truths_that_may_lack=0.0):
    """What may lack is a share of the truth's messages: between processes queues are bounded."""
    found = figures(folder, f"{NAMESPACE[1:]}.crawler_")
    assert abs(found["distance_m"] - 300.0) < 1.5, found
    assert found["wrong_joint"] == 0, found
    assert found["welds_to_lock"] <= 15, found
    assert found["in_joint_p95_m"] <= 0.05, found
    assert found["in_joint_worst_m"] <= 0.15, found
    assert 20 <= found["welds"] <= 27, found
    assert found["positions_locked"] >= 0.4 * found["positions"], found
    positions = recorded(folder, "positions.csv")
    assert len(positions) == found["positions"], len(positions)
    # The truth is published twice as often as the odometer ticks.
    stamps = [float(row["stamp"]) for row in recorded(folder, "crawler/truth.csv")]
    steps = [after - before for before, after in zip(stamps, stamps[1:])]
    assert min(steps) > 0.04, min(steps)
    lacking = sum(round(step / 0.05) - 1 for step in steps)
    assert lacking <= truths_that_may_lack * len(stamps), f"{lacking} of {len(stamps)}"
    welds = [row for row in recorded(folder, "welds.csv") if row["weld"]]
    assert all(row["weld_id"] == f"W{10 * (int(row['weld']) + 1):05d}" for row in welds), welds
    fused = recorded(folder, "fused.csv")
    # The scales that are learnt: the second wheel is 0.8 % too large.
    assert abs(float(fused[-1]["wheel_2.scale"]) - 1 / 1.008) < 0.003, fused[-1]
    assert any(row[f"wheel_{i}.health"] == "slipping" for row in fused for i in (1, 2, 3))


def check_state(folder):
    """The one state, in the map: from the welds, the odometers and the IMU."""
    found = figures(folder, f"{NAMESPACE[1:]}.estimator_")
    assert found["position_rmse_m"] <= 0.15, found
    assert found["position_worst_m"] <= 0.5, found
    assert found["orientation_rmse_deg"] <= 1.0, found
    assert found["in_ellipsoid_percent"] >= 90.0, found
    assert found["weld_accepted"] >= 10, found
    assert found["restarts"] == 0, found


def one_process(launch_scripts, scratch):
    run(launch_scripts / "crawler.yaml", scratch / "mission")
    check(scratch / "mission")
    check_state(scratch / "mission")


def in_bends(launch_scripts, scratch):
    """Each wheel goes its own way through the bends of the route; the fusion finds them, and the position goes by
    those of the tally too."""
    run(launch_scripts / "crawler_bends.yaml", scratch / "mission")
    found = figures(scratch / "mission", f"{NAMESPACE[1:]}.crawler_")
    assert abs(found["distance_m"] - 300.0) < 0.3, found
    assert found["wrong_joint"] == 0, found
    # The consensus needs 11, and these wheels without the bends of the tally 8.
    assert found["welds_to_lock"] <= 6, found
    assert found["in_joint_p95_m"] <= 0.05, found
    assert found["in_joint_worst_m"] <= 0.15, found
    bends = recorded(scratch / "mission", "bends.csv")
    with (launch_scripts.parent /
          "components/simulators/crawler_simulation/data/tally_bends.csv").open(newline="") as file:
        tally = list(csv.DictReader(file))
    # The crawler starts at the weld of joint 11.
    origin = float([row for row in tally if row["kind"] == "weld"][11]["chainage_m"])
    # Of 12 degrees over 8 m they are too weak for wheels like these.
    passed = [row for row in tally if row["kind"] == "bend" and float(row["angle_deg"]) >= 30.0
              and origin < float(row["chainage_m"]) < origin + 290.0]
    assert len(passed) == 4, passed
    for bend in passed:
        seen = [row for row in bends
                if abs(float(row["distance"]) + origin - float(bend["chainage_m"])) < 1.0]
        assert seen, (bend, bends)
        assert any(abs(math.degrees(float(row["angle"])) - float(bend["angle_deg"])) < 4.0 for row in seen), seen


def several_processes(launch_scripts, scratch):
    """The same composition with each component in a process of its own, over DDS."""
    text = (launch_scripts / "crawler.yaml").read_text()
    composition = scratch / "crawler_isolated.yaml"
    composition.write_text(text.replace("  - type:", "  - isolate: true\n    type:"))
    # No faster than messages get from process to process.
    (scratch / "run").mkdir()
    run(composition, scratch / "run/mission", "rate:=25.0")
    check(scratch / "run/mission", truths_that_may_lack=0.01)
    check_state(scratch / "run/mission")


def without_a_tally(launch_scripts, scratch):
    """The start is known, the joints are learnt; a second run goes by what the first one learnt."""
    learnt = scratch / "learnt.csv"
    # Welds whose chainage is that of the run are not on the centre line of the pipe.
    text = (launch_scripts / "crawler.yaml").read_text().replace(
        "      weld.tally: $(arg tally)\n", "").replace(
            "centre_line.file: $(share pipescout_crawler_simulation)/centre_line.csv",
            "start.position: [132.0, 0.0, 0.0]\n      start.heading: [0.0, 0.02]")
    locator = text.index("pipescout::WeldLocator")
    composition = scratch / "learning.yaml"
    composition.write_text(text[:locator] + text[locator:].replace(
        "tally: $(arg tally)", f"tally: ''\n      start.joint: 0\n      learnt_tally: {learnt}"))
    (scratch / "run").mkdir()
    run(composition, scratch / "run/first")
    joints = list(csv.DictReader(learnt.open(newline="")))
    assert len(joints) >= 20, joints
    tally = launch_scripts.parent / "components/simulators/crawler_simulation/data/tally.csv"
    lengths = [row["joint_length_m"] for row in csv.DictReader(tally.open(newline=""))]
    # Joint 0 of the run is joint 11 of the tally.
    for joint in joints[:-1]:
        error = float(joint["joint_length_m"]) - float(lengths[int(joint["id"][1:]) + 11])
        assert abs(error) < 3 * float(joint["joint_length_sd_m"]), joint
    # The first ones teach the scale.
    later = sorted(float(joint["joint_length_sd_m"]) for joint in joints[len(joints) // 2:-1])
    assert later[len(later) // 2] < 0.05, later

    composition = scratch / "knowing.yaml"
    composition.write_text(text[:locator] + text[locator:].replace("$(arg tally)", str(learnt)))
    run(composition, scratch / "run/second", "seed:=8")
    positions = recorded(scratch / "run/second", "positions.csv")
    truth = recorded(scratch / "run/second", "crawler/truth.csv")
    assert positions[-1]["locked"] == "1", positions[-1]
    assert abs(int(positions[-1]["joint"]) + 11 - int(truth[-1]["joint"])) <= 1, positions[-1]


def main():
    case, launch_scripts, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    {"one_process": one_process, "in_bends": in_bends, "several_processes": several_processes,
     "without_a_tally": without_a_tally}[case](launch_scripts, scratch)


if __name__ == "__main__":
    main()
