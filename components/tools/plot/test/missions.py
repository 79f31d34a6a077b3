# SPDX-License-Identifier: Apache-2.0
"""Small mission folders, made as `pipescout summary` makes them."""

import json
import math
from pathlib import Path

START = 1000.0
JOINT = 12.0
WHEELS = ("wheel_1", "wheel_2", "wheel_3")
READINGS = "reading,stamp,a,b,a.standard_deviation,b.standard_deviation,a.valid,b.valid\n"
FUSED_READINGS = "reading,stamp,distance,standard_deviation,status,fusion_set,a.rejection,b.rejection\n"


def write_csv(path: Path, columns, rows) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [",".join(columns), *(",".join(map(str, row)) for row in rows)]
    path.write_text("\n".join(lines) + "\n")


def crawler(folder: Path, seconds: int = 100, speed: float = 0.3) -> Path:
    """A run of three wheels, of which the second slips between 30 and 40 s. Gives the data's folder."""
    data = folder / "crawler"
    stamps = [START + 0.1 * k for k in range(10 * seconds)]
    _write_fused(data, stamps, speed)
    _write_places(data, stamps, speed)
    write_csv(data / "welds.csv", ["stamp", "distance", "confidence", "weld_id"],
              [(START + k * JOINT / speed, k * JOINT, 0.9 + 0.01 * k, f'"W,{k}"' if k > 1 else "")
               for k in range(1, int(seconds * speed / JOINT) + 1)])
    write_csv(data / "eddy_current.csv", ["stamp", "x1", "y1"],
              [(START + 0.02 * k, _pulse(0.02 * k * speed), -_pulse(0.02 * k * speed) if k % 97 else "nan")
               for k in range(50 * seconds)])
    return data


def _pulse(distance: float) -> float:
    from_weld = (distance + JOINT / 2) % JOINT - JOINT / 2
    return from_weld * math.exp(-(from_weld / 0.04) ** 2) * 30


def _write_fused(data: Path, stamps, speed: float) -> None:
    rows = []
    for stamp in stamps:
        time = stamp - START
        slips, lost = 30 <= time < 40, 35 <= time < 36
        support = "" if lost else "1>3 3>1 2>1" if slips else "1>2 1>3 2>1 2>3 3>1 3>2"
        row = [f"{stamp:.9f}", time * speed, 0.01, speed, "no consensus" if lost else "ok", support]
        for wheel in WHEELS:
            bad = slips and wheel == "wheel_2"
            row += ["unsupported" if bad else "none", "slipping" if bad else "ok", 1, 0.01]
        rows.append(row)
    wheels = [f"{wheel}.{column}" for wheel in WHEELS
              for column in ("rejection", "health", "scale", "scale_standard_deviation")]
    write_csv(data / "fused.csv", ["stamp", "distance", "standard_deviation", "speed", "status",
                                   "support", *wheels], rows)


PLACE = ["stamp", "odometer_distance", "known", "locked", "joint", "joint_probability", "orientation",
         "distance_into_joint", "chainage", "standard_deviation", "double_slip_detected",
         "tally_error_detected"]


def place(stamp, travelled, joint, into_joint, **other):
    """A row of positions.csv or truth.csv; the tally's joints have the length of the true ones."""
    values = {"stamp": f"{stamp:.9f}", "odometer_distance": travelled, "known": 1, "locked": 1,
              "joint": joint, "joint_probability": 1, "orientation": "forward",
              "distance_into_joint": into_joint, "chainage": joint * JOINT + into_joint,
              "standard_deviation": 0.02, "double_slip_detected": 0, "tally_error_detected": 0} | other
    return [values[column] for column in PLACE]


def _write_places(data: Path, stamps, speed: float) -> None:
    truth, positions = [], []
    for stamp in stamps:
        travelled = (stamp - START) * speed
        joint = int(travelled // JOINT)
        truth.append(place(stamp, travelled, joint, travelled - joint * JOINT))
        known, locked = travelled > 2, travelled > 6
        positions.append(place(stamp, travelled, joint if locked else joint + 3,
                               travelled - joint * JOINT + 0.01, known=int(known), locked=int(locked),
                               double_slip_detected=int(15 < travelled < 16)))
    write_csv(data / "truth.csv", PLACE, truth)
    write_csv(data / "positions.csv", PLACE, positions)


def readings(folder: Path, offsets: str = "[0.1, 0.2]") -> Path:
    """A mission of single readings."""
    data = folder / "odometry"
    data.mkdir(parents=True, exist_ok=True)
    (folder / "mission.yaml").write_text(
        "components:\n  - type: \"pipescout::OdometryFusion\"\n    name: odometry_fusion\n"
        f"    parameters:\n      offsets: {offsets}\n")
    (data / "readings.csv").write_text(READINGS + "1,1.0,5.1,5.0,0.05,0.05,1,1\n2,1.1,5.2,4.1,0.05,0.05,1,1\n")
    (data / "fused.csv").write_text(FUSED_READINGS + "1,1.0,5.2,0.03,ok,1 2,none,none\n"
                                    "2,1.1,nan,nan,no consensus,,unsupported,stuck\n")
    return data


def alignment(path: Path, welds: int = 60) -> Path:
    """A run that reads 0.2 % short, with a slip half way, a weld that only one side has, each."""
    rows = []
    for k in range(welds):
        ledger = 12.0 * k
        run = ledger * 0.998 + 5 + (0.5 if k > welds // 2 else 0)
        if k == 20:
            rows.append(("", ledger, f"W{k}", "", "", 0.01))
        elif k == 40:
            rows.append((run, "", "", "", "", 0.02))
        else:
            rows.append((run, ledger, f"W{k}", ledger - run, 0.03, 0.9 if k == 10 else 0.9999))
    write_csv(path, ["run_chainage", "ledger_chainage", "ledger_id", "difference", "standard_deviation",
                     "probability"], rows)
    return path


def reproduction(path: Path) -> Path:
    """As `pipescout reproduce in-pipe --json` writes it."""
    rows = [{"figure": "weld_found_percent", "study": f"Weld detector at {decibels} dB, 10 km",
             "measure": "welds found, %", "value": value, "mean": value, "worst": value - 1,
             "per_seed": [value - 1, value + 1]} for decibels, value in ((12, 99.0), (6, 60.0))]
    rows += [{"study": "Bends, the rules compared", "measure": f"{rule}: error of a bend, {what}, m", "value": value}
             for rule, scale in (("consensus", 10.0), ("average", 1.0))
             for what, value in (("median", 0.01 * scale), ("95 %", 0.02 * scale), ("worst", 0.03 * scale))]
    path.write_text(json.dumps({"figures": {}, "rows": rows, "seeds": [1, 2]}))
    return path
