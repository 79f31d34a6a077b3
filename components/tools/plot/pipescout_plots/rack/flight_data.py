# SPDX-License-Identifier: Apache-2.0
"""The tables of a flight over a rack (docs/tables.md)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy
import yaml

from ..csv_table import Table
from ..recording import Missing, Recording
from . import rotations

AXES = ("x", "y", "z", "rotation_x", "rotation_y", "rotation_z")
_QUATERNION = ("qx", "qy", "qz", "qw")
_WHY = "the tables of a flight over a rack have it"
_NO_TRUTH = "ground truth is available in simulated flights only"
MISSING_FOR = 0.5
"""Seconds without a sample that are drawn as a gap."""


@dataclass
class Poses:
    """Poses of the camera in the rack frame at rising times (seconds, absolute)."""

    times: numpy.ndarray
    positions: numpy.ndarray
    quaternions: numpy.ndarray
    deviations: numpy.ndarray | None = None
    """(n, 6): of x, y, z and the rotations about these axes, metres and radians."""
    correlation_xy: numpy.ndarray | None = None

    @property
    def rotations(self) -> numpy.ndarray:
        return rotations.from_quaternions(self.quaternions)

    def positions_at(self, times: numpy.ndarray) -> numpy.ndarray:
        """NaN before the first, after the last, and in a gap."""
        result = numpy.stack([numpy.interp(times, self.times, column, left=numpy.nan, right=numpy.nan)
                              for column in self.positions.T], axis=-1)
        result[self._in_gap(times)] = numpy.nan
        return result

    def rotations_at(self, times: numpy.ndarray) -> numpy.ndarray:
        result = rotations.interpolate(self.times, self.quaternions, times)
        result[self._in_gap(times)] = numpy.nan
        return result

    def _in_gap(self, times: numpy.ndarray) -> numpy.ndarray:
        after = numpy.clip(numpy.searchsorted(self.times, times), 1, max(len(self.times) - 1, 1))
        if len(self.times) < 2:
            return self.times[0] != times
        return ((self.times[after] - self.times[after - 1] > MISSING_FOR)
                & (times != self.times[after]) & (times != self.times[after - 1]))


def of_images(recording: Recording) -> bool:
    """Whether these are tables of `pipescout rack track`: poses, and a state for each image, no more."""
    return not (recording.folder / "pose.csv").is_file() and (recording.folder / "poses.csv").is_file()


def read_poses(recording: Recording) -> Poses:
    """Raises Missing and BadData."""
    deviations = [f"{axis}_standard_deviation" for axis in AXES]
    name = "poses.csv" if of_images(recording) else "pose.csv"
    table = recording.table(name, _WHY, ["stamp", "x", "y", "z", *_QUATERNION, *deviations,
                                               "x_y_correlation"])
    poses = _poses(table)
    poses.deviations = numpy.stack([table.numbers[name] for name in deviations], axis=-1)
    poses.correlation_xy = table.numbers["x_y_correlation"]
    return poses


def read_truth(recording: Recording) -> Poses:
    """Raises Missing and BadData."""
    return _poses(recording.table("truth.csv", _NO_TRUTH, ["stamp", "x", "y", "z", *_QUATERNION]))


def read_truth_if_any(recording: Recording) -> Poses | None:
    return read_truth(recording) if (recording.folder / "truth.csv").is_file() else None


def _poses(table: Table) -> Poses:
    table.require_rising("stamp")
    for column in ("x", "y", "z", *_QUATERNION):
        table.require_finite(column)
    return Poses(table.numbers["stamp"], numpy.stack([table.numbers[name] for name in "xyz"], axis=-1),
                 numpy.stack([table.numbers[name] for name in _QUATERNION], axis=-1))


@dataclass
class Commands:
    times: numpy.ndarray
    linear: numpy.ndarray
    angular: numpy.ndarray


def read_commands(recording: Recording) -> Commands:
    """Raises Missing and BadData."""
    linear = [f"linear_{axis}" for axis in "xyz"]
    angular = [f"angular_{axis}" for axis in "xyz"]
    table = recording.table("command.csv", "no velocity was commanded", ["stamp", *linear, *angular])
    table.require_rising("stamp")
    return Commands(table.numbers["stamp"],
                    numpy.stack([table.numbers[name] for name in linear], axis=-1),
                    numpy.stack([table.numbers[name] for name in angular], axis=-1))


def untracked(recording: Recording) -> list[tuple[float, float]]:
    """The times from one image without a pose to the next image with one, once there has been one.
    Raises BadData."""
    try:
        name = "images.csv" if of_images(recording) else "state.csv"
        table = recording.table(name, _WHY, ["stamp"], ["status"])
    except Missing as reason:
        recording.note(f"losses are not marked: {reason}")
        return []
    table.require_rising("stamp")
    stamps = table.numbers["stamp"]
    tracking = numpy.array([status == "tracking" for status in table.texts["status"]])
    if not tracking.any():
        return [(float(stamps[0]), float(stamps[-1]))]
    first = int(numpy.argmax(tracking))
    result: list[tuple[float, float]] = []
    begin = None
    for stamp, good in zip(stamps[first:].tolist(), tracking[first:]):
        if good and begin is not None:
            result.append((begin, stamp))
            begin = None
        elif not good and begin is None:
            begin = stamp
    return result if begin is None else [*result, (begin, float(stamps[-1]))]


def done_way_points(recording: Recording) -> list[tuple[float, int]]:
    """When each way-point was reached or given up, and its number from 1. Raises BadData."""
    if of_images(recording):
        return []
    try:
        table = recording.table("way_points.csv", "its source counts none", ["stamp", "done"])
    except Missing as reason:
        recording.note(f"way-points are not marked: {reason}")
        return []
    table.require_rising("stamp")
    result: list[tuple[float, int]] = []
    before = 0
    for stamp, done in zip(table.numbers["stamp"].tolist(), table.numbers["done"].tolist()):
        if numpy.isfinite(done) and done > before:
            result.append((stamp, int(done)))
            before = done
    return result


@dataclass
class Servo:
    """What mission.yaml says of the flight: where it should go, and how the camera is mounted."""

    way_points: numpy.ndarray
    """(n, 4): x, y, z of the vehicle in the rack frame, yaw."""
    R_base_camera: numpy.ndarray
    camera_position: numpy.ndarray
    """In the vehicle's frame, metres."""

    def vehicle(self, poses: Poses) -> Poses:
        """The path of the vehicle whose camera these poses are of."""
        bases = poses.rotations @ self.R_base_camera.T
        return replace(poses, positions=poses.positions - bases @ self.camera_position)


def read_servo(recording: Recording) -> Servo:
    """Without a mission.yaml, or with several servos: no way-points and a camera that looks down."""
    servo = Servo(numpy.empty((0, 4)), rotations.DOWNWARD_CAMERA, numpy.zeros(3))
    try:
        told = _parameters(recording, "pipescout::VisualServo")
        servo.way_points = numpy.array(told.get("way_points") or [], dtype=float).reshape(-1, 4)
        angles = told.get("camera.roll_pitch_yaw") or []
        if len(angles) == 3:
            servo.R_base_camera = rotations.from_roll_pitch_yaw(*map(float, angles))
        place = told.get("camera.position") or []
        if len(place) == 3:
            servo.camera_position = numpy.array(place, dtype=float)
    except _NOT_READ as problem:
        recording.note(f"mission.yaml: parameters of the visual servo are not available ({problem})")
    return servo


def read_true_offsets(recording: Recording, pipes: list[str]) -> dict[str, float]:
    """By pipe, metres, when one simulation flew over the rack that was recorded; else empty. `pipes`: all
    of the rack file, in its order."""
    try:
        simulation = _parameters(recording, "pipescout::RackSimulation")
        if not simulation or simulation.get("rack") != _mission(recording)["summary"]["rack.rack"]:
            return {}
        offsets = [float(value) for value in simulation.get("offsets") or [0.0] * len(pipes)]
        return dict(zip(pipes, offsets)) if len(offsets) == len(pipes) else {}
    except _NOT_READ as problem:
        recording.note(f"mission.yaml: true offsets of the pipes are not available ({problem})")
        return {}


_NOT_READ = (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, ValueError, AttributeError)


def _parameters(recording: Recording, component_class: str) -> dict:
    """What mission.yaml says of the one component of this class; empty without such or with several.
    Raises _NOT_READ."""
    found = [_flat(component.get("parameters") or {}) for component in _mission(recording)["components"]
             if component["type"] == component_class]
    return found[0] if len(found) == 1 else {}


def _mission(recording: Recording) -> dict:
    """The components and the options of the tables, by their names with dots. Raises _NOT_READ."""
    path = recording.mission / "mission.yaml"
    mission = yaml.safe_load(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return {"components": mission.get("components", []),
            "summary": {"rack.rack": None, **_flat(mission.get("summary") or {})}}


def _flat(parameters: dict, prefix: str = "") -> dict:
    """Nested maps are parameters with dots in their names."""
    result = {}
    for name, value in parameters.items():
        if isinstance(value, dict):
            result.update(_flat(value, f"{prefix}{name}."))
        else:
            result[f"{prefix}{name}"] = value
    return result
