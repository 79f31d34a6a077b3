# SPDX-License-Identifier: Apache-2.0
"""What the pictures over time share: the axis, losses and way-points on it, lines with gaps."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes

from .. import style
from ..decimation import decimate, envelope
from ..recording import Recording
from .flight_data import MISSING_FOR, done_way_points, untracked

NUMBER_GAP = 0.09
"""Between way-points that are marked, of the width of the narrowest panel: their numbers do not touch."""
LOSS = "#F6D9C8"
"""A pale vermillion, behind the lines."""


class Timeline:
    """Times are seconds since `start`."""

    def __init__(self, recording: Recording, start: float, end: float) -> None:
        self.start = start
        self.end = end
        self._unit, self.label = style.time_axis(end - start)
        self._losses = untracked(recording)
        self._way_points = self._apart(recording, done_way_points(recording))

    def __call__(self, stamps: numpy.ndarray) -> numpy.ndarray:
        return (stamps - self.start) / self._unit

    def mark(self, axes: Axes, numbers: bool = False) -> None:
        """Losses and way-points; numbers above the panel."""
        for begin, end in self._losses:
            axes.axvspan(*self(numpy.array([begin, end])), color=LOSS, linewidth=0, zorder=0,
                         label="no pose")
        for stamp, number in self._way_points:
            place = float(self(numpy.array(stamp)))
            axes.axvline(place, color=style.GREY, linewidth=0.5, linestyle=(0, (1, 1.5)), zorder=1)
            if numbers:
                axes.annotate(str(number), (place, 1), (0, 1.5), xycoords=("data", "axes fraction"),
                              textcoords="offset points", ha="center", va="bottom", fontsize=5.5,
                              color=style.GREY)
        axes.set_xlim(0, float(self(numpy.array(self.end))))

    def _apart(self, recording: Recording, way_points: list[tuple[float, int]]) -> list[tuple[float, int]]:
        """Of those that are too close to each other the first."""
        result: list[tuple[float, int]] = []
        during = [entry for entry in way_points if self.start <= entry[0] <= self.end]
        for stamp, number in during:
            if not result or stamp - result[-1][0] >= NUMBER_GAP * (self.end - self.start):
                result.append((stamp, number))
        if len(during) < len(way_points):
            recording.notes.append(f"{len(way_points) - len(during)} way-points are not of the time of the "
                                   "flight and are not marked: has their source another clock?")
        elif len(result) < len(during):
            recording.notes.append(f"only {len(result)} of {len(during)} way-points are marked, so that "
                                   "their numbers do not touch")
        return result

    def line(self, axes: Axes, stamps: numpy.ndarray, values: numpy.ndarray, **how) -> None:
        for piece in pieces(stamps):
            axes.plot(*decimate(self(stamps[piece]), values[piece], _groups(piece, stamps)), **how)

    def band(self, axes: Axes, stamps: numpy.ndarray, low: numpy.ndarray, high: numpy.ndarray,
             **how) -> None:
        for piece in pieces(stamps):
            axes.fill_between(*envelope(self(stamps[piece]), low[piece], high[piece],
                                        _groups(piece, stamps)), linewidth=0, **how)


def pieces(stamps: numpy.ndarray) -> list[slice]:
    """Between gaps: no line bridges one."""
    edges = [0, *(numpy.flatnonzero(numpy.diff(stamps) > MISSING_FOR) + 1).tolist(), len(stamps)]
    return [slice(start, end) for start, end in zip(edges[:-1], edges[1:])]


def _groups(piece: slice, stamps: numpy.ndarray) -> int:
    """A piece's share of what a column can show."""
    return max(1, style.GROUPS * (piece.stop - piece.start) // len(stamps))


def unique_legend(*panels: Axes) -> tuple[list, list[str]]:
    """Each label once, in the order in which they come."""
    entries: dict[str, object] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels()):
            entries.setdefault(label, handle)
    return list(entries.values()), list(entries)
