# SPDX-License-Identifier: Apache-2.0
"""What the tools write: lists of welds, ledgers, leaks, tracks, camera poses and trajectories."""

from __future__ import annotations

import math
from pathlib import Path

from missions import JOINT, START, write_csv

AXES = ("x", "y", "z", "rotation_x", "rotation_y", "rotation_z")


def ledger(path: Path, welds: int = 60) -> Path:
    """As `pipescout ledger` writes it, with a bend."""
    rows = [(f"W{k:05}", "weld", JOINT * k, 0.05 + 0.001 * k, JOINT if k + 1 < welds else "",
             0.02 if k + 1 < welds else "", 1, 1) for k in range(welds)]
    rows.insert(20, ("B1", "bend", JOINT * 19.5, 0.1, "", "", 1, 1))
    write_csv(path, ["id", "kind", "chainage_m", "chainage_sd_m", "joint_length_m", "joint_length_sd_m", "seen",
                     "passed"], rows)
    return path


def welds(path: Path, count: int = 30) -> Path:
    """As `pipescout inspect welds` writes it; the tenth is not certain."""
    write_csv(path, ["Log distance [m]", "Feature type", "standard_deviation_m", "confidence", "amplitude", "width_m",
                     "phase_rad", "strength", "match"],
              [(JOINT * (k + 1), "Weld", 0.01, 0.5 if k == 10 else 0.99, 1, 0.04, 0, 9, 0.9) for k in range(count)])
    return path


LEAKS = ["id", "state", "severity", "probability", "first_time", "last_time", "frames", "passes", "mean_delta_k",
         "mean_delta_low_k", "mean_delta_high_k", "peak_delta_k", "peak_delta_low_k", "peak_delta_high_k", "length_m",
         "length_deviation_m", "delta_growth_k_per_h", "length_growth_m_per_h", "map_x", "map_y", "map_z",
         "map_x_deviation", "map_y_deviation", "map_z_deviation", "map_xy_covariance", "map_xz_covariance",
         "map_yz_covariance", "latitude", "longitude", "altitude_m"]


def leaks(folder: Path, placed: bool = True) -> Path:
    """As `pipescout inspect leaks` writes it: two near each other, one cleared."""
    rows = []
    for number, (x, y, delta, severity, state) in enumerate((
            (10, 1, 40, "moderate", "raised"), (10.1, 1.1, 90, "severe", "raised"), (30, 1.3, 160, "critical", "raised"),
            (3, 13, 20, "minor", "cleared")), 1):
        place = (x, y, 3, 0.2, 0.3, 0.1, 0, 0, 0) if placed else ("",) * 9
        rows.append((number, state, severity, 0.99, "", "", 20, 1, delta, delta - 5, delta + 6, 1.3 * delta, "", "", 0.4,
                     0.1, "", "", *place, "", "", ""))
    write_csv(folder / "leaks.csv", LEAKS, rows)
    return folder


def seen_leaks(folder: Path) -> Path:
    """Tables of a mission: images of 100 s, two leaks raised, one of them of unknown place."""
    write_csv(folder / "detections.csv", ["stamp", "fault", "pipes", "leaks", "threshold", "longest_pipe",
                                          "reference_temperature", "largest_delta"],
              [(START + k, "blurred" if k == 50 else "", k % 3, int(20 < k < 40), 9, 300, 290,
                40 + k if 20 < k < 40 else "") for k in range(100)])
    write_csv(folder / "events.csv", ["stamp", "event", "leak", "state", "severity", "x", "y", "z", "peak_delta"],
              [(START + 25, "raised", 1, "raised", "severe", 8, 1, 0, 50),
               (START + 26, "raised", 2, "raised", "severe", "", "", "", 50),
               (START + 28, "updated", 1, "raised", "severe", 8.1, 1, 0, 50)])
    return folder


def image_track(folder: Path) -> Path:
    """As `pipescout track` writes it: found after 2 s, predicted for a while, an image that could not be read."""
    rows = []
    for k in range(80):
        time = 0.1 * k
        state = "detecting" if time < 2 else "coasting" if 4 <= time < 4.5 else "locked"
        values = ("",) * 8 if time < 2 else (320 + k, 240 + 5 * math.sin(time), 600, 0.1, 1, 1, 4, 0.01)
        rows.append((f"{k}.png", time, state, int(time >= 2), *values, 0.9, 1, 1, ""))
    rows.append(("broken.png", *("",) * 14, "not an image"))
    write_csv(folder / "track.csv", ["image", "time", "state", "track", "x", "y", "length", "angle", "x_sd", "y_sd",
                                     "length_sd", "angle_sd", "confidence", "in_view", "regions", "problem"], rows)
    return folder


def camera_poses(folder: Path) -> Path:
    """As `pipescout rack track` writes it: straight down, along the rack."""
    names = [f"{a}_{b}_correlation" for k, a in enumerate(AXES) for b in AXES[k + 1:]]
    rows, images = [], []
    for k in range(60):
        stamp = START + 0.1 * k
        images.append((stamp, f"{k}.png", "lost" if 30 <= k < 40 else "tracking", "", 0.9, 50))
        if not 30 <= k < 40:
            rows.append((stamp, 1.0, 2 + 0.05 * k, 3.0, 1, 0, 0, 0, math.pi, 0, 0, *[0.01] * 6, *[0.0] * len(names)))
    write_csv(folder / "poses.csv", ["stamp", "x", "y", "z", "qx", "qy", "qz", "qw", "roll", "pitch", "yaw",
                                     *(f"{axis}_standard_deviation" for axis in AXES), *names], rows)
    write_csv(folder / "images.csv", ["stamp", "name", "status", "reason", "quality", "matched"], images)
    return folder


def trajectory(folder: Path) -> Path:
    """As `pipescout estimate` writes it."""
    write_csv(folder / "trajectory.csv", ["stamp", "x", "y", "z", "x_deviation", "y_deviation", "z_deviation", "qx", "qy",
                                          "qz", "qw", "vx", "vy", "vz"],
              [(START + 0.1 * k, 20 * math.cos(0.01 * k), 20 * math.sin(0.01 * k), 0.001 * k, 0.1, 0.1, 0.2, 0, 0, 0, 1,
                0, 0, 0) for k in range(600)])
    return folder
