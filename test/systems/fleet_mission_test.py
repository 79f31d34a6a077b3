#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Three robots at once, each in a namespace of its own in one domain: all of them complete, and what each leaves
behind is its own.

    fleet_mission_test.py LAUNCH_SCRIPTS SCRATCH
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys

from mission import figures

ROBOTS = ("robot_1", "robot_2", "robot_3")
# What runs beside this may use the same domain, but not this namespace.
FLEET = f"fleet_test_{os.getpid()}"
TIMEOUT = 900  # s, of all
# Common to all robots of a domain.
SHARED = {"/diagnostics", "/rosout", "/parameter_events"}


def environment():
    return dict(os.environ, ROS_LOCALHOST_ONLY="1",
                ROS_DOMAIN_ID=os.environ.get("ROS_DOMAIN_ID", str(1 + os.getpid() % 100)))


def start(launch_scripts, scratch, robot):
    log = (scratch / f"{robot}.log").open("w")
    command = ["pipescout", "run", launch_scripts / "crawler.yaml", "--namespace", f"/{FLEET}/{robot}",
               "--out", scratch / robot, "--param", "crawler_simulation.length:=150.0",
               # One after the other ends, while the others go on.
               f"seed:={7 + ROBOTS.index(robot)}"]
    return subprocess.Popen(list(map(str, command)), env=environment(), stdout=log,
                            stderr=subprocess.STDOUT)


def topics_of(bag):
    text = subprocess.run(["pipescout", "bag", "info", str(bag)], check=True, stdout=subprocess.PIPE,
                          text=True, timeout=TIMEOUT).stdout
    return dict(re.findall(r"Topic: (\S+) \| .*?Count: (\d+)", text))


def check(folder, robot):
    summary = (folder / "summary.json").read_text()
    assert "Complete" in summary and "Failed" not in summary, summary
    found = figures(folder, f"{FLEET}.{robot}.crawler_")
    assert abs(found["distance_m"] - 150.0) < 1.5, found
    topics = topics_of(folder / "bag")
    foreign = [name for name in topics
               if name not in SHARED and not name.startswith(f"/{FLEET}/{robot}/")]
    assert not foreign, foreign
    for name in ("clock", "weld", "odometer/fused", "odometry/filtered", "ground_truth/pipe_position"):
        assert int(topics[f"/{FLEET}/{robot}/{name}"]) > 0, topics
    # Nobody drives the clock of another: its stamps are as many as its steps.
    assert found["wrong_joint"] == 0, found


def main():
    launch_scripts, scratch = map(pathlib.Path, sys.argv[1:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    running = {robot: start(launch_scripts, scratch, robot) for robot in ROBOTS}
    try:
        codes = {robot: process.wait(TIMEOUT) for robot, process in running.items()}
    finally:
        for robot, process in running.items():
            process.kill()
            print(robot, (scratch / f"{robot}.log").read_text(), flush=True)
    assert set(codes.values()) == {0}, codes
    for robot in ROBOTS:
        check(scratch / robot, robot)


if __name__ == "__main__":
    main()
