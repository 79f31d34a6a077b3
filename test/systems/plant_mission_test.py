#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A tour of inspection that the navigator drives through a simulated plant: a box that no map shows, a
closed road, people; each aisle is driven along, and nothing is touched.

    plant_mission_test.py CASE LAUNCH_SCRIPTS SCRATCH
"""

import os
import pathlib
import re
import shutil
import sys

from mission import pipescout

NAMESPACE = f"/plant_test_{os.getpid()}"
TIMEOUT = 140  # s, of a run


def without_recorder(text):
    """The simulation itself says what came of the tour; recordings are judged by other missions."""
    begin = text.index("  - type: pipescout::BagRecorder")
    text = text[:begin] + "complete_when: [plant_simulation]\n"
    return re.sub(r"      wait_for_subscribers\.true_odometry: .*\n", "", text).replace(", bag_recorder]", "]")


def run(composition, folder, *arguments):
    # Simulated time is everybody's in a domain, unless the topic is the mission's own.
    text = without_recorder(composition.read_text())
    own = folder.parent / composition.name
    own.write_text(text.replace("    parameters:", "    remappings: {/clock: clock}\n"
                                                   "    parameters:"))
    return pipescout("run", own, "--namespace", NAMESPACE, "--out", folder, "rate:=1000.0",
                     *arguments, timeout=TIMEOUT)


def check(text, rows):
    # A contact ends the run with an error.
    found = re.search(r"(\d+) rows driven along, (\d+) left out, (\d+) % of their pipes", text)
    assert found, "the tour did not end"
    assert int(found.group(1)) == rows and int(found.group(2)) == 0, found.group(0)
    assert int(found.group(3)) >= 95, found.group(0)


def one_process(launch_scripts, scratch):
    check(run(launch_scripts / "plant_patrol.yaml", scratch / "mission"), 3)
    for name in ("plant.yaml", "plant.pgm", "plant.geojson"):
        assert (scratch / "mission/map" / name).stat().st_size > 100, name


def main():
    case, launch_scripts, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    {"one_process": one_process}[case](launch_scripts, scratch)


if __name__ == "__main__":
    main()
