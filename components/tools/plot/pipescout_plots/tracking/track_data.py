# SPDX-License-Identifier: Apache-2.0
"""The tables of a tracked pipe (docs/tables.md)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy

from ..csv_table import Table
from ..recording import Missing, Recording
from ..time_axis import TimeAxis

SECTION = ("u", "v", "length", "angle")
ESTIMATES = {
    "estimate": "",
    "best particle": "best_particle.",
    "robust mean": "robust_mean.",
    "weighted mean": "weighted_mean.",
}
TRACKED = ("locked", "coasting")


def read_track(recording: Recording) -> Table:
    numbers = ["stamp", "confidence", "half_width"] + [
        prefix + name for prefix in ESTIMATES.values() for name in SECTION]
    track = recording.table("track.csv", "no pipe was tracked", numbers, ["state"])
    track.require_rising("stamp")
    return track


def read_truth(recording: Recording) -> Table:
    truth = recording.table("truth.csv", "only a simulation knows where the pipe is",
                            ["stamp", "beside_pipe", "in_view", *SECTION, "half_width", "whole_width", "width",
                             "height"])
    truth.require_rising("stamp")
    return truth


def section(table: Table, prefix: str = "") -> numpy.ndarray:
    """(n, 4): x, y, length, angle."""
    return numpy.column_stack([table.numbers[prefix + name] for name in SECTION])


def tracked(track: Table) -> numpy.ndarray:
    """Whether an estimate is told, for each line."""
    return numpy.isin(track.texts["state"], TRACKED)


def time_of_mission(track: Table) -> TimeAxis:
    stamps = track.numbers["stamp"]
    return TimeAxis(stamps[0], stamps[-1])


def angle_between(a: numpy.ndarray, b: numpy.ndarray) -> numpy.ndarray:
    """Of axes, within half a turn of pi."""
    return (a - b + numpy.pi / 2) % numpy.pi - numpy.pi / 2


@dataclass(frozen=True)
class Errors:
    """Of each estimate against the truth, where both are told."""

    stamps: numpy.ndarray
    of: dict[str, numpy.ndarray]
    """By the name of the estimate, (n, 4): x and y, px; length, px; angle, rad."""


def read_errors(recording: Recording) -> Errors:
    track, truth = read_track(recording), read_truth(recording)
    seen = (truth.numbers["in_view"] > 0) & (truth.numbers["beside_pipe"] > 0)
    told = tracked(track)
    _, left, right = numpy.intersect1d(numpy.round(track.numbers["stamp"][told], 6),
                                       numpy.round(truth.numbers["stamp"][seen], 6), return_indices=True)
    if len(left) == 0:
        raise Missing(f"no line of {track.path} has a truth of the same time")
    true = section(truth)[seen][right]
    errors = {}
    for name, prefix in ESTIMATES.items():
        difference = section(track, prefix)[told][left] - true
        difference[:, 3] = angle_between(section(track, prefix)[told][left][:, 3], true[:, 3])
        errors[name] = difference
    return Errors(track.numbers["stamp"][told][left], errors)


def ends(sections: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Of sections (n, 4): both ends of each, (n, 2)."""
    half = 0.5 * sections[:, 2:3] * numpy.column_stack([numpy.cos(sections[:, 3]), numpy.sin(sections[:, 3])])
    return sections[:, :2] - half, sections[:, :2] + half
