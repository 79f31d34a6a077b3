#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the odometry mission as a user does, and judges what it left behind.

    odometry_mission_test.py CASE LAUNCH_SCRIPTS SCRATCH
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys

SUPPORT = ["2 3", "1 2 3", "2 3", "1 3", "2 3", "1 2 3", "1 2 3", "1 2", "2 3", "1 2 3"]


# What runs beside this may use the same domain, but not this namespace.
NAMESPACE = f"/mission_test_{os.getpid()}"


def run(composition, *arguments):
    return pipescout("run", composition, "--namespace", NAMESPACE, *arguments)


def pipescout(*arguments):
    environment = dict(os.environ, ROS_LOCALHOST_ONLY="1", ROS_DOMAIN_ID=str(1 + os.getpid() % 100))
    result = subprocess.run(["pipescout", *map(str, arguments)], env=environment, timeout=100,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(result.stdout)
    assert result.returncode == 0, f"exit code {result.returncode}"
    return result.stdout


def odometry_section(folder):
    sections = json.loads((folder / "summary.json").read_text())["sections"]
    found = [section for section in (sections.values() if isinstance(sections, dict) else sections)
             if section["title"].startswith("Odometry")]
    assert len(found) == 1, f"{len(found)} odometry sections"
    return found[0]


def check_paper_mission(folder):
    table = odometry_section(folder)["table"]
    rows = table["rows"]
    assert len(rows) == 10, f"{len(rows)} rows"
    support = table["columns"].index("support set")
    assert [row[support] for row in rows] == SUPPORT, rows
    difference = next(i for i, name in enumerate(table["columns"]) if name.startswith("difference"))
    assert all(abs(row[difference]) <= 0.006 for row in rows[:9]), rows
    for name in ("mission.yaml", "readings.csv", "fused.csv"):
        assert all(path.stat().st_size > 0 for path in folder.rglob(name)), name
        assert any(folder.rglob(name)), name


def one_process(launch_scripts, scratch):
    run(launch_scripts / "odometry.yaml", "--out", scratch / "mission")
    check_paper_mission(scratch / "mission")


def several_processes(launch_scripts, scratch):
    """The same composition with each component in a process of its own, over DDS."""
    text = (launch_scripts / "odometry.yaml").read_text()
    composition = scratch / "isolated.yaml"
    composition.write_text(text.replace("  - type:", "  - isolate: true\n    type:"))
    run(composition, "--out", scratch / "mission")
    check_paper_mission(scratch / "mission")


def own_readings(launch_scripts, scratch):
    readings = scratch / "own.csv"
    readings.write_text("reading,front,rear\n1,1.00,1.01\n2,2.00,nan\n3,3.02,3.01\n")
    run(launch_scripts / "own_readings.yaml", f"readings:={readings}", "--out",
              scratch / "mission", "--param",
              "odometer_replay.standard_deviations:=[0.02, 0.02]")
    rows = odometry_section(scratch / "mission")["table"]["rows"]
    assert len(rows) == 3, rows


def reproduce(_, scratch):
    pipescout("reproduce", "odometry", "--json", scratch / "odometry.json")
    result = json.loads((scratch / "odometry.json").read_text())
    assert set(result) == {"figures", "rows", "seeds"}, result.keys()
    assert result["figures"]["rows_1_to_9_max_abs_error_m"] <= 0.006
    assert len(result["rows"]) == 10
    for row, support in zip(result["rows"], SUPPORT):
        assert {"readings", "support", "fused_ml", "fused_paper", "paper"} <= set(row), row
        assert row["support"] == [int(number) for number in support.split()], row


def main():
    case, launch_scripts, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    {"one_process": one_process, "several_processes": several_processes,
     "own_readings": own_readings, "reproduce": reproduce}[case](launch_scripts, scratch)


if __name__ == "__main__":
    main()
