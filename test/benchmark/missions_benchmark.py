#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether missions and their replays repeat, and how fast a replay is.

The crawler's, the rack's and the patrol's mission, shortened, are recorded with all their messages
and replayed into the same components without the simulator: at the highest rate, again, and in
real time; the output bags must be the same bytes. Then each mission runs alone, beside a recorder,
beside busy loops and beside a reader that stops (test/systems/listeners_test.py). Builds what it
runs. Takes half an hour, a third of it for the crawler's replay in real time; for the speed give
it an idle machine.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import yaml

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LAUNCH_SCRIPTS = ROOT / "launch_scripts"
LISTENERS_TEST = ROOT / "test" / "systems" / "listeners_test.py"
LEAST_PATROL_SPEED = 10.0  # times real time
# What shortens the mission, by mission; its simulator.
MISSIONS = {
    "crawler": (["--param", "crawler_simulation.length:=150.0"], "crawler_simulation"),
    "rack": (["--param", "visual_servo.way_points:=[0.9, 4.0, 2.6, 1.5707963]", "duration:=40.0",
              "rate:=1000.0"], "rack_simulation"),
    "patrol": (["--param", "patrol_simulation.row.length:=6.0",
                "--param", "patrol_simulation.leaks:=[3.0, 0.3, 80.0]", "rate:=1000.0"],
               "patrol_simulation"),
}


def build():
    """The environment in which the missions run."""
    command = (f". {LAUNCH_SCRIPTS}/build_environment.sh && colcon build --packages-up-to "
               "pipescout_systems --event-handlers console_start_end- console_direct- "
               "--cmake-args -DCMAKE_BUILD_TYPE=Release >&2 && set +u && . install/setup.bash "
               "&& env -0")
    result = subprocess.run(["bash", "-c", command], cwd=ROOT, stdout=subprocess.PIPE, check=True)
    pairs = result.stdout.decode().split("\0")
    return dict(pair.split("=", 1) for pair in pairs if "=" in pair) | {"ROS_LOCALHOST_ONLY": "1"}


def pipescout(environment, *arguments):
    subprocess.run(["pipescout", *map(str, arguments)], env=environment, stdout=sys.stderr,
                   stderr=sys.stderr, check=True)


def without_simulator(mission, simulator):
    """The composition that is left of a mission for a replay; nobody waits for who is gone."""
    composition = yaml.safe_load((LAUNCH_SCRIPTS / f"{mission}.yaml").read_text())
    gone = {simulator, "bag_recorder"}
    composition["components"] = [each for each in composition["components"]
                                 if each["name"] not in gone]
    for component in composition["components"]:
        parameters = component.get("parameters", {})
        for name in [name for name in parameters if name.startswith("wait_for_subscribers")]:
            del parameters[name]
    del composition["complete_when"]
    return yaml.safe_dump(composition, sort_keys=False)


def seconds_of(bag):
    """The duration of a bag by its metadata."""
    text = (bag / "metadata.yaml").read_text()
    return int(re.search(r"duration:\n\s+nanoseconds: (\d+)", text).group(1)) / 1e9


def content(folder):
    return {file.name: file.read_bytes() for file in sorted(folder.iterdir())}


def replays(environment, mission, scratch):
    """Whether all replays are the same bytes, and their speed, times real time."""
    shorter, simulator = MISSIONS[mission]
    pipescout(environment, "run", LAUNCH_SCRIPTS / f"{mission}.yaml", "--out", scratch / "recorded",
              *shorter, "--param", "bag_recorder.thinned_topics:=[]",
              "--param", "bag_recorder.thinned_periods:=[]")
    bag = scratch / "recorded" / "bag"
    composition = scratch / "replay.yaml"
    composition.write_text(without_simulator(mission, simulator))
    outputs = []
    took = []
    for name, more in (("first", []), ("second", []), ("real_time", ["--rate", "1"])):
        out = scratch / name / "bag"  # of one name: files and metadata have it
        out.parent.mkdir()
        begin = time.monotonic()
        pipescout(environment, "run", composition, "--bag", bag, "--record", out,
                  "--out", scratch / f"{name}_mission", *more)
        took.append(time.monotonic() - begin)
        outputs.append(content(out))
    identical = outputs[0] == outputs[1] == outputs[2]
    return identical, seconds_of(bag) / min(took[:2])


def keeps_in_company(environment, mission, scratch):
    command = [sys.executable, "-B", str(LISTENERS_TEST), mission, str(LAUNCH_SCRIPTS), str(scratch)]
    return subprocess.run(command, env=environment, stdout=sys.stderr,
                          stderr=sys.stderr).returncode == 0


def print_figure(name, value, target):
    met = "met" if value >= target else "NOT MET"
    print(f"{name:<32}{value:12.3f}   at least {target:8.3f}   {met}")


def main():
    parser = argparse.ArgumentParser(prog="test/benchmark/run.sh missions", description=__doc__)
    parser.add_argument("--json", metavar="FILE", help="writes figures and rows to FILE")
    parser.add_argument("--missions", nargs="+", default=list(MISSIONS), choices=list(MISSIONS),
                        help="only these")
    parser.add_argument("--replay-only", action="store_true", help="no missions in company")
    options = parser.parse_args()
    rows = []
    try:
        environment = build()
        environment.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
        with tempfile.TemporaryDirectory(prefix="pipescout_missions_") as scratch:
            for mission in options.missions:
                folder = pathlib.Path(scratch) / mission
                folder.mkdir()
                identical, speed = replays(environment, mission, folder)
                row = {"case": mission, "replay_identical": int(identical),
                       "replay_speed": round(speed, 2)}
                if not options.replay_only:
                    row["listener_identical"] = int(
                        keeps_in_company(environment, mission, folder / "company"))
                print(row, flush=True)
                rows.append(row)
    except subprocess.CalledProcessError as error:
        sys.exit(f"{error.cmd[0]} failed ({error.returncode})")
    print()
    figures = {"replay_identical": min(row["replay_identical"] for row in rows)}
    print_figure("replay_identical", figures["replay_identical"], 1)
    for row in rows:
        figures[f"replay_{row['case']}_speed"] = row["replay_speed"]
    if "patrol" in options.missions:
        print_figure("replay_patrol_speed", figures["replay_patrol_speed"], LEAST_PATROL_SPEED)
    if not options.replay_only:
        figures["listener_identical"] = min(row["listener_identical"] for row in rows)
        print_figure("listener_identical", figures["listener_identical"], 1)
    if options.json:
        document = {"figures": figures, "rows": rows, "seeds": [7]}
        pathlib.Path(options.json).write_text(json.dumps(document, indent=2) + "\n")


if __name__ == "__main__":
    main()
