# SPDX-License-Identifier: Apache-2.0
"""The tables of a state estimator (docs/tables.md)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy

from ..csv_table import Table
from ..recording import Missing, Recording
from ..time_axis import TimeAxis

AXES = ("x", "y", "z", "rotation_x", "rotation_y", "rotation_z")
_WHY = "the tables of a state estimator have it"
_NO_TRUTH = "ground truth is available in simulated runs only"
SAME_TIME = 1e-3
"""Seconds: a measurement and what became of it have stamps that rounding sets apart by less."""


@dataclass
class Estimates:
    """At rising times (seconds, absolute): metres, radians."""

    times: numpy.ndarray
    positions: numpy.ndarray
    deviations: numpy.ndarray
    """(n, 6), in the order of AXES."""
    correlation_xy: numpy.ndarray


def of_recording(recording: Recording) -> bool:
    """Whether these are tables of `pipescout estimate`: a trajectory, no more."""
    return not (recording.folder / "estimate.csv").is_file() and (recording.folder / "trajectory.csv").is_file()


def read_estimates(recording: Recording) -> Estimates:
    """Raises Missing and BadData."""
    if of_recording(recording):
        return _read_trajectory(recording)
    deviations = [f"{axis}_standard_deviation" for axis in AXES]
    table = recording.table("estimate.csv", _WHY, ["stamp", *AXES[:3], *deviations, "x_y_correlation"])
    table.require_rising("stamp")
    for column in AXES[:3]:
        table.require_finite(column)
    return Estimates(table.numbers["stamp"], _columns(table, AXES[:3]), _columns(table, deviations),
                     table.numbers["x_y_correlation"])


def _read_trajectory(recording: Recording) -> Estimates:
    """It says nothing of rotations, and of x and y together."""
    deviations = [f"{axis}_deviation" for axis in AXES[:3]]
    table = recording.table("trajectory.csv", _WHY, ["stamp", *AXES[:3], *deviations])
    table.require_rising("stamp")
    for column in AXES[:3]:
        table.require_finite(column)
    unknown = numpy.full((len(table), 3), numpy.nan)
    return Estimates(table.numbers["stamp"], _columns(table, AXES[:3]),
                     numpy.concatenate((_columns(table, deviations), unknown), axis=1), unknown[:, 0])


def read_true_positions(recording: Recording) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Times, and (n, 3) in metres; none without a truth. Raises BadData."""
    if not (recording.folder / "truth.csv").is_file():
        return numpy.empty(0), numpy.empty((0, 3))
    table = recording.table("truth.csv", _NO_TRUTH, ["stamp", *AXES[:3]])
    table.require_rising("stamp")
    for column in AXES[:3]:
        table.require_finite(column)
    return table.numbers["stamp"], _columns(table, AXES[:3])


@dataclass
class Errors:
    """Estimate minus truth at rising times; `deviations` is what the estimates say of them."""

    times: numpy.ndarray
    errors: numpy.ndarray
    deviations: numpy.ndarray
    position_nees: numpy.ndarray
    pose_nees: numpy.ndarray


def read_errors(recording: Recording) -> Errors:
    """Raises Missing and BadData."""
    table = recording.table("errors.csv", _NO_TRUTH, ["stamp", *AXES, "position_nees", "pose_nees"])
    table.require_rising("stamp")
    times = table.numbers["stamp"]
    estimates = read_estimates(recording)
    rows, known = nearest(estimates.times, times)
    deviations = numpy.where(known[:, None], estimates.deviations[rows], numpy.nan)
    return Errors(times, _columns(table, AXES), deviations, table.numbers["position_nees"],
                  table.numbers["pose_nees"])


@dataclass
class Factors:
    """In the order of the keyframes that they are of; `times` are those of the measurements."""

    times: numpy.ndarray
    kinds: numpy.ndarray
    outcomes: numpy.ndarray
    chi_squares: numpy.ndarray
    """Per degree of freedom; NaN for what has none."""
    weights: numpy.ndarray


def read_factors(recording: Recording) -> Factors:
    """Raises Missing and BadData."""
    table = recording.table("factors.csv", "no measurement was processed",
                            ["stamp", "chi_square", "degrees", "weight"], ["kind", "outcome"])
    table.require_finite("stamp")
    degrees = table.numbers["degrees"]
    chi_squares = numpy.full(len(table), numpy.nan)
    numpy.divide(table.numbers["chi_square"], degrees, out=chi_squares, where=degrees > 0)
    return Factors(table.numbers["stamp"], numpy.array(table.texts["kind"], dtype=object),
                   numpy.array(table.texts["outcome"], dtype=object), chi_squares, table.numbers["weight"])


def read_factors_if_any(recording: Recording) -> Factors | None:
    """Raises BadData."""
    try:
        return read_factors(recording)
    except Missing as reason:
        recording.note(f"outcomes of single measurements are not available: {reason}")
        return None


def read_states(recording: Recording, numbers: list[str], texts: list[str]) -> Table:
    """These columns of state.csv and its stamps, which rise. Raises Missing and BadData."""
    table = recording.table("state.csv", _WHY, ["stamp", *numbers], texts)
    table.numbers["stamp"] = _since_first_time(table.numbers["stamp"], table.numbers["stamp"])
    table.require_rising("stamp")
    return table


def read_sources(recording: Recording, states: Table) -> Table:
    """Of sources.csv the stamps, sources and states. Raises Missing and BadData."""
    table = recording.table("sources.csv", "the estimator has no source", ["stamp"], ["source", "state"])
    table.numbers["stamp"] = _since_first_time(table.numbers["stamp"], states.numbers["stamp"])
    table.require_rising("stamp")
    return table


def _since_first_time(stamps: numpy.ndarray, states: numpy.ndarray) -> numpy.ndarray:
    """An estimator that knows no time yet says 0: then it is that of the first state with one."""
    known = states[states > 0]
    return numpy.where(stamps == 0, known[0], stamps) if known.size else stamps


def time_of_run(recording: Recording, *stamps: numpy.ndarray) -> TimeAxis:
    """From the first state to the last, and all of these stamps. Raises BadData."""
    try:
        stamps = (*stamps, read_states(recording, [], []).numbers["stamp"])
    except Missing:
        pass  # a picture that needs the states says so itself
    every = numpy.concatenate(stamps)
    return TimeAxis(float(every.min()), float(every.max()))


def nearest(stamps: numpy.ndarray, wanted: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
    """By wanted stamp the row of the nearest of the rising `stamps`, and whether it is the same time."""
    after = numpy.clip(numpy.searchsorted(stamps, wanted), 0, len(stamps) - 1)
    before = numpy.maximum(after - 1, 0)
    rows = numpy.where(wanted - stamps[before] < stamps[after] - wanted, before, after)
    return rows, numpy.abs(stamps[rows] - wanted) < SAME_TIME


def _columns(table: Table, names) -> numpy.ndarray:
    return numpy.stack([table.numbers[name] for name in names], axis=-1)
