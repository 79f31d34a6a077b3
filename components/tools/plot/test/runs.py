# SPDX-License-Identifier: Apache-2.0
"""Runs of a state estimator, made as `pipescout summary` makes them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy
from missions import write_csv

START = 3000.0
AXES = ("x", "y", "z", "rotation_x", "rotation_y", "rotation_z")
POSE = ["stamp", "x", "y", "z", "qx", "qy", "qz", "qw", "roll", "pitch", "yaw"]
DEVIATIONS = [f"{axis}_standard_deviation" for axis in AXES]
CORRELATIONS = [f"{a}_{b}_correlation" for k, a in enumerate(AXES) for b in AXES[k + 1:]]
BIASES = [f"{sensor}_bias_{axis}{ending}" for sensor in ("gyro", "accelerometer")
          for ending in ("", "_standard_deviation") for axis in "xyz"]
RUNS_AT = 6.0
"""Seconds after the start at which it runs."""
OUTAGE = (60.0, 85.0)
TRAP = (85.0, 91.0)
"""Fixes come back, 700 m away; then the right ones do."""


def run(mission: Path, seconds: float = 150.0, seed: int = 1, crawler: bool = False) -> Path:
    """A ground robot on a figure of eight with GPS and odometer, of which GPS fails for a while, or a
    crawler on a straight line without. Gives the folder of the data."""
    chance = numpy.random.default_rng(seed)
    data = mission / "estimator"
    data.mkdir(parents=True)
    times = numpy.arange(0, seconds, 0.1)
    truth = _path(times, seconds, crawler)
    write_csv(data / "truth.csv", POSE, [_pose(*row) for row in zip(times, truth)])
    _write_estimates(data, times, truth, chance)
    _write_states(data, times, chance, crawler)
    _write_factors(data, times, chance, crawler)
    _write_sources(data, crawler)
    if not crawler:
        _write_fixes(data, times, truth, chance)
    return data


def _path(times, seconds: float, crawler: bool):
    if crawler:
        return numpy.stack((0.3 * times, 0.002 * times, 0 * times, 0 * times), axis=-1)
    phase = 2 * numpy.pi * times / seconds
    x, y = 40 * numpy.sin(phase), 15 * numpy.sin(2 * phase)
    return numpy.stack((x, y, 0.2 * numpy.sin(5 * phase),
                        numpy.unwrap(numpy.arctan2(numpy.gradient(y), numpy.gradient(x)))), axis=-1)


def _stamp(time: float) -> str:
    return f"{START + time:.9f}"


def _pose(time: float, place) -> list:
    x, y, z, yaw = place
    return [_stamp(time), x, y, z, 0, 0, numpy.sin(yaw / 2), numpy.cos(yaw / 2), 0, 0,
            numpy.arctan2(numpy.sin(yaw), numpy.cos(yaw))]


def _deviations(time: float):
    lost = max(0.0, min(time, 95.0) - OUTAGE[0]) if OUTAGE[0] < time < 97 else 0.0
    across = 0.15 + 0.8 * numpy.exp(-(time - RUNS_AT) / 4) + 0.02 * lost
    return numpy.array([across, 0.7 * across, 0.3, 0.004, 0.004, 0.01 + 0.1 * numpy.exp(-(time - RUNS_AT) / 6)])


def _write_estimates(data: Path, times, truth, chance) -> None:
    estimates, errors = [], []
    noise = numpy.zeros(6)
    for time, place in zip(times, truth):
        noise = 0.97 * noise + numpy.sqrt(1 - 0.97 ** 2) * chance.normal(size=6)
        if time < RUNS_AT:
            continue
        deviation = _deviations(time)
        # x and y share a third.
        shared = numpy.copy(noise)
        shared[1] = 0.3 * noise[0] + numpy.sqrt(1 - 0.09) * noise[1]
        error = deviation * shared
        estimates.append(_pose(time, place + error[[0, 1, 2, 5]])
                         + [*deviation, 0.3, *[0] * 14, 1.5, 0, 0, 0, 0, 0.1, *[0.01] * 6])
        errors.append([_stamp(time), *error, (noise[:3] ** 2).sum(), (noise ** 2).sum()])
    velocities = [f"{kind}_{axis}" for kind in ("linear", "angular") for axis in "xyz"]
    write_csv(data / "estimate.csv", [*POSE, *DEVIATIONS, *CORRELATIONS, *velocities,
                                      *(f"{name}_standard_deviation" for name in velocities)], estimates)
    write_csv(data / "errors.csv", ["stamp", *AXES, "position_nees", "pose_nees"], errors)


def _write_states(data: Path, times, chance, crawler: bool) -> None:
    rows = [["0.000000000", "starting", "imu", 0, "nan", 0, "none", *[""] * 14]]
    accelerometer, gyro = numpy.array([0.03, -0.05, 0.02]), numpy.array([0.002, -0.001, 0.0015])
    since = "nan"
    for time in times[::2]:
        lost = OUTAGE[0] <= time < TRAP[1] + 3 and not crawler
        phase = ("starting" if time < 2 else "aligning" if time < RUNS_AT else
                 "coasting" if lost and time > OUTAGE[0] + 5 else "running")
        since = "nan" if time < RUNS_AT or crawler else time - OUTAGE[0] if lost else 0.1
        row = [_stamp(time), phase, "heading, from motion" if phase == "aligning" else "", 0, since,
               int(time > TRAP[1] + 3), "none"]
        if time < RUNS_AT:
            rows.append([f'"{cell}"' if "," in str(cell) else cell for cell in row] + [""] * 14)
            continue
        left = numpy.exp(-(time - RUNS_AT) / 15)
        width = 0.002 * left + 0.0002
        rows.append([*row, *(gyro * (1 - left) + 0.1 * width * chance.normal(size=3)), *[width] * 3,
                     *(accelerometer * (1 - left)), *[10 * width] * 3,
                     1.012 - 0.012 * left, 0.02 * left + 0.001])
    write_csv(data / "state.csv", ["stamp", "phase", "waits_for", "standing_still", "since_absolute_position",
                                   "restarts", "restart_reason", *BIASES, "odometer_scale",
                                   "odometer_scale_standard_deviation"], rows)


def _write_factors(data: Path, times, chance, crawler: bool) -> None:
    rows = []
    for k, time in enumerate(times):
        if time < RUNS_AT:
            continue
        slips = 110 <= time < 114
        chi = chance.chisquare(1) * (60 if slips else 1)
        rows.append((time - 0.03, "odometer", "accepted", chi, 1, min(1.0, 3 / max(chi, 3.0))))
        rows.append((time, "non_holonomic", "accepted", chance.chisquare(2), 2, 1.0))
        if k % 2 == 0:
            rows.append((time, "imu", "accepted", chance.chisquare(15), 15, 1.0))
        if crawler and k % 120 == 0:
            rows.append((time - 0.4, "weld", "late" if k % 600 == 0 else "accepted", chance.chisquare(1), 1, 1.0))
        if not crawler and k % 5 == 0 and not OUTAGE[0] <= time < OUTAGE[1]:
            trapped = TRAP[0] <= time < TRAP[1] or k % 85 == 0
            rows.append((time, "gps", "gated" if trapped else "accepted",
                         4e5 if TRAP[0] <= time < TRAP[1] else 80 if trapped else chance.chisquare(3), 3,
                         0.0 if trapped else 1.0))
    rows.append((90.0, "zero_velocity", "quarantined", "nan", 3, 0.0))
    write_csv(data / "factors.csv", ["stamp", "kind", "outcome", "chi_square", "degrees", "weight"],
              [(_stamp(row[0]), *row[1:]) for row in rows])


def _write_sources(data: Path, crawler: bool) -> None:
    rows = [("0.000000000", name, "absent") for name in
            ("imu", "odometer", "relative_pose", "gps", "visual_pose", "heading", "weld")]
    rows += [(_stamp(0.0), "imu", "trusted"), (_stamp(1.0), "odometer", "trusted")]
    if crawler:
        rows += [(_stamp(RUNS_AT), "weld", "trusted")]
    else:
        rows += [(_stamp(1.5), "gps", "candidate"), (_stamp(4.0), "gps", "trusted"),
                 (_stamp(OUTAGE[0] + 2), "gps", "absent"), (_stamp(TRAP[0]), "gps", "candidate"),
                 (_stamp(TRAP[0] + 1), "gps", "doubted"), (_stamp(TRAP[1]), "gps", "candidate"),
                 (_stamp(TRAP[1] + 3), "gps", "trusted")]
    write_csv(data / "sources.csv", ["stamp", "source", "state", "accepted", "gated", "held", "refused"],
              [(*row, 1, 0, 0, 0) for row in rows])


def _write_fixes(data: Path, times, truth, chance) -> None:
    rows = []
    for k, (time, place) in enumerate(zip(times, truth)):
        if k % 5 or OUTAGE[0] <= time < OUTAGE[1]:
            continue
        wrong = [700, 0] if TRAP[0] <= time < TRAP[1] else [6, -5] if k % 85 == 0 else [0, 0]
        x, y = place[:2] + wrong + 0.8 * chance.normal(size=2)
        rows.append((_stamp(time), 46.5, 8.25, 500, x, y, 0))
    write_csv(data / "gps.csv", ["stamp", "latitude", "longitude", "altitude", "x", "y", "z"], rows)


def reproduction(path: Path) -> Path:
    """As `pipescout reproduce estimator --json` writes it."""
    rows = [{"figure": "stream_position_rmse_m", "study": "stream", "measure": "position", "value": 0.0141},
            {"figure": "outage_drift_percent", "study": "outage", "measure": "drift", "value": 0.2,
             "mean": 0.18, "worst": 0.28, "per_seed": [0.1, 0.28]}]
    path.write_text(json.dumps({"figures": {}, "rows": rows, "seeds": [1001]}))
    return path
