#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Flies launch_scripts/rack.yaml, with the loop closed through topics, once per seed, and judges by
the simulation's truth how far the UAV was from each way-point while it stayed there.

    rack_flights.py [--first SEED] [--flights N] [--json FILE] [NAME:=VALUE ...]

A way-point is kept when in the last half second before it is done the UAV was never farther from it
than 3 cm and 1 degree. NAME:=VALUE go to `pipescout run`. The workspace must be in the environment
(source install/setup.bash).
"""

import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import yaml

from mission import figures, pipescout, recorded

COMPOSITION = pathlib.Path(__file__).resolve().parents[2] / "launch_scripts/rack.yaml"
LARGEST_DISTANCE = 0.03  # m
LARGEST_TURN = 1.0  # degrees
STAY = 0.5  # s
TIMEOUT = 600  # s, of a flight


def way_points_to_keep():
    for component in yaml.safe_load(COMPOSITION.read_text())["components"]:
        flat = component["parameters"].get("way_points")
        if flat:
            return [flat[i:i + 4] for i in range(0, len(flat), 4)]
    sys.exit(f"{COMPOSITION}: no way_points")


def heading(row):
    """Of the UAV whose camera looks down: its x axis is up in the image."""
    x, y, z, w = (float(row[name]) for name in ("qx", "qy", "qz", "qw"))
    return math.atan2(2 * (x * x + z * z) - 1, 2 * (z * w - x * y))


def errors(truth, done, way_point):
    """Largest distance, m, and turn, degrees, from a way-point before it was done."""
    stayed = [row for row in truth if done - STAY <= float(row["stamp"]) <= done]
    distance = max(math.dist([float(row[name]) for name in "xyz"], way_point[:3])
                   for row in stayed)
    turn = max(abs(math.remainder(heading(row) - way_point[3], 2 * math.pi)) for row in stayed)
    return distance, math.degrees(turn)


def fly(seed, way_points, arguments, folder):
    pipescout("run", COMPOSITION, "--out", folder, f"seed:={seed}", *arguments, timeout=TIMEOUT)
    found = figures(folder, "rack_")
    truth = recorded(folder, "rack/truth.csv")
    kept = [errors(truth, float(row["stamp"]), way_points[int(row["done"]) - 1])
            for row in recorded(folder, "way_points.csv") if int(row["done"]) > 0]
    return {"seed": seed, "way_points": found["way_points"], "errors": kept,
            "losses": found["losses"], "tracked_percent": found["tracked_percent"],
            "position_median_m": found["position_median_m"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=1001)
    parser.add_argument("--flights", type=int, default=10)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("arguments", nargs="*", metavar="NAME:=VALUE")
    options = parser.parse_args()
    way_points = way_points_to_keep()
    rows = []
    wanted = within = 0
    for seed in range(options.first, options.first + options.flights):
        wanted += len(way_points)
        try:
            with tempfile.TemporaryDirectory() as scratch:
                row = fly(seed, way_points, options.arguments,
                          pathlib.Path(scratch) / "mission")
        except (AssertionError, subprocess.TimeoutExpired) as failure:
            print(f"seed {seed}: not completed, {failure}", flush=True)
            rows.append({"seed": seed, "errors": []})
            continue
        rows.append(row)
        kept = sum(distance <= LARGEST_DISTANCE and turn <= LARGEST_TURN
                   for distance, turn in row["errors"])
        within += kept
        distance = max((error[0] for error in row["errors"]), default=math.nan)
        turn = max((error[1] for error in row["errors"]), default=math.nan)
        print(f"seed {seed}: {kept} of {row['way_points']:.0f} way-points kept, largest "
              f"{distance:.4f} m {turn:.3f} deg; pose of {row['tracked_percent']:.1f} % of the "
              f"images, {row['losses']:.0f} losses, median error "
              f"{row['position_median_m']:.4f} m", flush=True)
    totals = {"flight_way_points": wanted, "flight_way_points_kept": within,
              "flight_way_points_kept_percent": 100 * within / wanted}
    for name, value in totals.items():
        print(f"{name} {value:g}")
    if options.json:
        options.json.write_text(json.dumps({
            "figures": totals, "rows": rows,
            "seeds": list(range(options.first, options.first + options.flights))}, indent=1))
    return 0 if within == wanted else 1


if __name__ == "__main__":
    sys.exit(main())
