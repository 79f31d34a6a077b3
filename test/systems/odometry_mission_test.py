#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the odometry mission as a user does, and judges what it left behind.

    odometry_mission_test.py CASE LAUNCH_SCRIPTS SCRATCH
"""

import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

from mission import expect_healthy, pipescout, recorded

# Of the ten readings of the paper: docs/papers/odometry.md.
SUPPORT = ["2 3", "1 2 3", "2 3", "1 3", "2 3", "1 2 3", "1 2 3", "1 2", "2 3", "1 2 3"]
FUSED = [5.5097, 5.4612, 5.5146, 5.5213, 5.5048, 5.5148, 5.5308, 5.5110, 5.4748, 5.5384]
DEVIATION = [0.039, 0.033, 0.039, 0.041, 0.039, 0.033, 0.033, 0.041, 0.039, 0.033]
PAPER = [5.51, 5.46, 5.51, 5.52, 5.51, 5.51, 5.53, 5.51, 5.48, 5.52]


# What runs beside this may use the same domain, but not this namespace.
NAMESPACE = f"/mission_test_{os.getpid()}"
TIMEOUT = 100  # s, of a run


def run(composition, *arguments):
    return pipescout("run", composition, "--namespace", NAMESPACE, *arguments, timeout=TIMEOUT)


def odometry_section(folder):
    sections = json.loads((folder / "summary.json").read_text())["sections"]
    found = [section for section in (sections.values() if isinstance(sections, dict) else sections)
             if section["title"].startswith("Odometry")]
    assert len(found) == 1, f"{len(found)} odometry sections"
    return found[0]


def columns(table):
    """The table by columns; the unit belongs to the name."""
    return {name: [row[index] for row in table["rows"]]
            for index, name in enumerate(table["columns"])}


def expect_near(values, expected, tolerance):
    assert len(values) == len(expected), values
    for number, (value, wanted) in enumerate(zip(values, expected), 1):
        if wanted is None:
            assert value is None, f"{number}: {value}"
        else:
            assert value is not None and abs(value - wanted) <= tolerance, f"{number}: {value}"


def check_paper_mission(folder):
    table = columns(odometry_section(folder)["table"])
    assert table["reading"] == list(range(1, 11)), table
    assert table["support set"] == SUPPORT, table
    expect_near(table["fused [m]"], FUSED, 6e-5)
    expect_near(table["standard deviation [m]"], DEVIATION, 6e-4)
    expect_near(table["paper [m]"], PAPER, 1e-9)
    # What the paper prints; reading 10 follows from none of its formulas.
    expect_near(table["fused [m]"][:9], PAPER[:9], 0.006)
    fused = recorded(folder, "fused.csv")
    assert [row["fusion_set"] for row in fused] == SUPPORT, fused
    expect_near([float(row["distance"]) for row in fused], FUSED, 6e-5)
    assert len(recorded(folder, "readings.csv")) == 10
    assert (folder / "mission.yaml").stat().st_size > 0


def one_process(launch_scripts, scratch):
    expect_healthy(run(launch_scripts / "odometry.yaml", "--out", scratch / "mission"))
    check_paper_mission(scratch / "mission")


def several_processes(launch_scripts, scratch):
    """The same composition with each component in a process of its own, over DDS."""
    text = (launch_scripts / "odometry.yaml").read_text()
    composition = scratch / "isolated.yaml"
    composition.write_text(text.replace("  - type:", "  - isolate: true\n    type:"))
    run(composition, "--out", scratch / "mission")
    check_paper_mission(scratch / "mission")


def behind_a_server(launch_scripts, scratch):
    """The same behind a discovery server, which tells the recorder of all topics."""
    port = str(20000 + os.getpid() % 10000)
    with subprocess.Popen(["pipescout", "discovery", "start", "-l", "127.0.0.1", "-p", port],
                          stdout=subprocess.PIPE, text=True) as server:
        assert "listens" in server.stdout.readline()
        os.environ["ROS_DISCOVERY_SERVER"] = f"127.0.0.1:{port}"
        try:
            several_processes(launch_scripts, scratch)
        finally:
            server.terminate()


def own_readings(launch_scripts, scratch):
    """An odometer that fails is left out; two that fail leave no consensus."""
    readings = scratch / "own.csv"
    readings.write_text("reading,front,middle,rear\n1,1.00,1.01,1.02\n2,2.00,2.01,nan\n"
                        "3,nan,3.01,nan\n4,4.02,4.01,9.99\n")
    run(launch_scripts / "own_readings.yaml", f"readings:={readings}", "--out",
        scratch / "mission", "--param", "odometer_replay.standard_deviations:=[0.02, 0.02, 0.02]")
    section = odometry_section(scratch / "mission")
    table = columns(section["table"])
    assert table["support set"] == ["1 2 3", "1 2", "", "1 2"], table
    expect_near(table["fused [m]"], [1.01, 2.005, None, 4.015], 6e-5)
    assert section["figures"][f"{NAMESPACE[1:]}.odometry_without_consensus"] == 1, section
    assert table["rear [m]"][1] is None, table
    fused = recorded(scratch / "mission", "fused.csv")
    assert [row["rear.rejection"] for row in fused] == [
        "none", "not a number", "not a number", "unsupported"], fused
    assert math.isnan(float(fused[2]["distance"])), fused


def reproduce(_, scratch):
    pipescout("reproduce", "odometry", "--json", scratch / "odometry.json", timeout=TIMEOUT)
    result = json.loads((scratch / "odometry.json").read_text())
    assert set(result) == {"figures", "revision", "rows", "seeds"}, result.keys()
    assert result["figures"]["rows_1_to_9_max_abs_error_m"] <= 0.006
    assert len(result["rows"]) == 10
    for row, support in zip(result["rows"], SUPPORT):
        assert {"readings", "support", "fused_ml", "fused_paper", "paper"} <= set(row), row
        assert row["support"] == [int(number) for number in support.split()], row


def main():
    case, launch_scripts, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    {"one_process": one_process, "several_processes": several_processes, "behind_a_server": behind_a_server,
     "own_readings": own_readings, "reproduce": reproduce}[case](launch_scripts, scratch)


if __name__ == "__main__":
    main()
