#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Drives the plant of patrol.yaml by goals of one's own, as a user does: with no tour, and during one.

    plant_test.py CASE LAUNCH_SCRIPTS SCRATCH
"""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys

from mission import environment, pipescout

NAMESPACE = f"/plant_test_{os.getpid()}"
TIMEOUT = 600  # s, of a run
# In the middle of aisle 1, where the robot starts.
GOAL = ("{pose: {header: {frame_id: map}, pose: {position: {x: 10.0, y: 20.25}, "
        "orientation: {w: 1.0}}}}")


class Plant:
    """The plant as it runs; what it says is read until a pattern is found."""

    def __init__(self, launch_scripts, scratch, *arguments):
        self.folder = scratch / "mission"
        self.process = subprocess.Popen(
            ["pipescout", "run", str(launch_scripts / "patrol.yaml"), "--namespace", NAMESPACE, "--out", str(self.folder),
             "rate:=4.0", *arguments],
            env=environment(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.told = ""

    def wait_for(self, pattern):
        for line in self.process.stdout:
            print(line, end="", flush=True)
            self.told += line
            if re.search(pattern, line):
                return
        raise AssertionError(f"the run ended without '{pattern}': {self.process.wait()}")

    def end(self):
        rest, _ = self.process.communicate(timeout=TIMEOUT)
        print(rest)
        self.told += rest
        return self.process.returncode


def drive(goal=GOAL):
    return pipescout("action", "send_goal", f"{NAMESPACE}/navigate_to_pose",
                     "nav2_msgs/action/NavigateToPose", goal, "--spin-time", "30", timeout=TIMEOUT)


def goals_until_interrupted(launch_scripts, scratch):
    plant = Plant(launch_scripts, scratch, "tour:=false")
    plant.wait_for("components are active")
    assert "Goal finished with status: SUCCEEDED" in drive()
    # Another frame: rejected, and the client is told why.
    refused = subprocess.run(
        ["pipescout", "action", "send_goal", f"{NAMESPACE}/navigate_to_pose",
         "nav2_msgs/action/NavigateToPose", GOAL.replace("map", "odom"), "--spin-time", "30"],
        env=environment(), capture_output=True, text=True, timeout=TIMEOUT)
    assert refused.returncode == 1, refused
    assert "the goal is in frame 'odom', not in 'map'" in refused.stderr, refused
    plant.process.send_signal(signal.SIGINT)
    assert plant.end() == 128 + signal.SIGINT
    assert "rows driven along" not in plant.told
    # What was driven until then is summarised.
    assert (plant.folder / "summary.json").stat().st_size > 100


def a_stated_duration(launch_scripts, scratch):
    plant = Plant(launch_scripts, scratch, "tour:=false", "duration:=20.0")
    assert plant.end() == 0
    assert re.search(r"^finished  .*patrol_simulation", plant.told, re.MULTILINE), plant.told


def main():
    case, launch_scripts, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    {"goals_until_interrupted": goals_until_interrupted,
     "a_stated_duration": a_stated_duration}[case](launch_scripts, scratch)


if __name__ == "__main__":
    main()
