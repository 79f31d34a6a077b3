#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sets the wall clock while a mission runs by it: the log says which clock was set, by how much and when,
and the readings go on.

    wall_clock_test.py CASE PRELOADED_LIBRARY SCRATCH
"""

import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys

from mission import environment

ROWS = 200
PERIOD = 0.05  # s
TIMEOUT = 300  # s, of the run
COMPOSITION = """
name: wall_clock
executor: {{type: single_threaded}}
components:
  - type: pipescout::OdometerReplay
    name: odometer_replay{isolate}
    parameters:
      file: {folder}/readings.csv
      standard_deviations: [0.01, 0.01, 0.01]
      period: {period}
      wait_for_subscribers: [odometry_fusion, bag_recorder]
  - type: pipescout::OdometerStreamFusion
    name: odometry_fusion{isolate}
    parameters:
      odometers: [a, b, c]
      sigmas_per_sqrt_metre: [0.004, 0.004, 0.004]
      inputs.topics: [odometer/readings]
      inputs.minimum_rates: [5.0]
      inputs.maximum_ages: [1.0]
      wait_for_subscribers: [bag_recorder]
  - type: pipescout::BagRecorder
    name: bag_recorder{isolate}
    stops_last: true
    parameters:
      output: $(mission_folder)/bag
      all: true
      source: odometer_replay
complete_when: [bag_recorder]
"""


def count(info, topic):
    found = re.search(rf"Topic: {topic} .*Count: (\d+)", info)
    assert found, info
    return int(found.group(1))


def run(library, scratch, isolate, set_by, said):
    (scratch / "readings.csv").write_text("a,b,c\n" + "".join(
        f"{0.01 * k:.3f},{0.01 * k + 0.001:.3f},{0.01 * k - 0.001:.3f}\n" for k in range(ROWS)))
    composition = scratch / "wall_clock.yaml"
    composition.write_text(COMPOSITION.format(
        folder=scratch, period=PERIOD, isolate="\n    isolate: true" if isolate else ""))
    offset = scratch / "offset"
    offset.write_bytes(struct.pack("q", 0))
    mission = scratch / "mission"
    process = subprocess.Popen(
        ["pipescout", "run", str(composition), "--namespace", f"/wall_clock_{os.getpid()}",
         "--out", str(mission)],
        env=dict(environment(), LD_PRELOAD=str(library), WALL_CLOCK=str(offset)),
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    told = ""
    for line in process.stdout:
        print(line, end="", flush=True)
        told += line
        # In the middle of the readings. Written over in place: the program has mapped the file.
        if re.match(r"[3-9]\d %", line) and offset.read_bytes() == struct.pack("q", 0):
            with offset.open("r+b") as file:
                file.write(struct.pack("q", set_by))
    assert process.wait(timeout=TIMEOUT) == 0
    assert len(re.findall(said, told)) == 1, told
    info = subprocess.run(["pipescout", "bag", "info", str(mission / "bag")], env=environment(),
                          capture_output=True, text=True, timeout=TIMEOUT, check=True).stdout
    print(info)
    namespace = f"/wall_clock_{os.getpid()}"
    assert count(info, f"{namespace}/odometer/readings") == ROWS
    # What is fused ends a while before the last reading, and a leap of the stamps takes a reading or two.
    fused = count(info, f"{namespace}/odometer/fused")
    assert fused >= 0.9 * ROWS * PERIOD / 0.1, fused


def main():
    case, library, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    back = r"\[WARN\].*the system clock of this machine was set back by 60\.0 s, from \S+Z to \S+Z"
    forward = back.replace("back", "forward")
    {"set_back": lambda: run(library, scratch, False, -60, back),
     "set_back_in_processes": lambda: run(library, scratch, True, -60, back),
     "set_forward": lambda: run(library, scratch, False, 60, forward)}[case]()


if __name__ == "__main__":
    main()
