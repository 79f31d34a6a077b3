# SPDX-License-Identifier: Apache-2.0
"""What the pictures over time share: losses and way-points on the axis."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes

from .. import style
from ..recording import Recording
from ..time_axis import TimeAxis
from .flight_data import MISSING_FOR, done_way_points, untracked

NUMBER_GAP = 0.09
"""Between way-points that are marked, of the width of the narrowest panel: their numbers do not touch."""
LOSS = "#F6D9C8"
"""A pale vermillion, behind the lines."""


class Timeline(TimeAxis):
    """With losses and way-points."""

    def __init__(self, recording: Recording, start: float, end: float) -> None:
        super().__init__(start, end, MISSING_FOR)
        self._losses = untracked(recording)
        self._way_points = self._apart(recording, done_way_points(recording))

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
        self.limit(axes)

    def _apart(self, recording: Recording, way_points: list[tuple[float, int]]) -> list[tuple[float, int]]:
        """Of those that are too close to each other the first."""
        result: list[tuple[float, int]] = []
        during = [entry for entry in way_points if self.start <= entry[0] <= self.end]
        for stamp, number in during:
            if not result or stamp - result[-1][0] >= NUMBER_GAP * (self.end - self.start):
                result.append((stamp, number))
        if len(during) < len(way_points):
            recording.note(f"{len(way_points) - len(during)} way-points are not of the time of the "
                                   "flight and are not marked: has their source another clock?")
        elif len(result) < len(during):
            recording.note(f"only {len(result)} of {len(during)} way-points are marked, so that "
                                   "their numbers do not touch")
        return result
