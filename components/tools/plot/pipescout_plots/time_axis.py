# SPDX-License-Identifier: Apache-2.0
"""An axis of time that several panels share, and lines with gaps on it."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes

from . import style
from .decimation import decimate, envelope

USUAL_GAP = 5.0
"""Usual intervals between samples that are drawn as a gap, unless the seconds are known."""


class TimeAxis:
    """Times are seconds since `start`, in the unit that `label` says."""

    def __init__(self, start: float, end: float, gap: float | None = None) -> None:
        """`gap`: seconds without a sample that no line bridges."""
        self.start = start
        self.end = end
        self._gap = gap
        self._unit, self.label = style.time_axis(end - start)

    def __call__(self, stamps: numpy.ndarray) -> numpy.ndarray:
        return (stamps - self.start) / self._unit

    def limit(self, axes: Axes) -> None:
        end = float(self(numpy.array(self.end)))
        axes.set_xlim(0, end if end > 0 else 1)

    def line(self, axes: Axes, stamps: numpy.ndarray, values: numpy.ndarray, **how) -> None:
        for piece in self._pieces(stamps):
            axes.plot(*decimate(self(stamps[piece]), values[piece], _groups(piece, stamps)), **how)

    def band(self, axes: Axes, stamps: numpy.ndarray, low: numpy.ndarray, high: numpy.ndarray,
             **how) -> None:
        for piece in self._pieces(stamps):
            axes.fill_between(*envelope(self(stamps[piece]), low[piece], high[piece],
                                        _groups(piece, stamps)), linewidth=0, **how)

    def _pieces(self, stamps: numpy.ndarray) -> list[slice]:
        return pieces(stamps, usual_gap(stamps) if self._gap is None else self._gap)


def usual_gap(stamps: numpy.ndarray) -> float:
    steps = numpy.diff(stamps)
    return USUAL_GAP * float(numpy.median(steps)) if steps.size else 1.0


def pieces(stamps: numpy.ndarray, gap: float) -> list[slice]:
    """Between gaps: no line bridges one."""
    edges = [0, *(numpy.flatnonzero(numpy.diff(stamps) > gap) + 1).tolist(), len(stamps)]
    return [slice(start, end) for start, end in zip(edges[:-1], edges[1:])]


def _groups(piece: slice, stamps: numpy.ndarray) -> int:
    """A piece's share of what a column can show."""
    return max(1, style.GROUPS * (piece.stop - piece.start) // len(stamps))
