# SPDX-License-Identifier: Apache-2.0
"""A pipe that `pipescout track` followed through images."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import style
from ..csv_table import Table
from ..recording import Missing, Recording
from ..time_axis import TimeAxis
from .track_data import TRACKED

_PANELS = (("x", "x [px]", 1.0), ("y", "y [px]", 1.0), ("angle", "angle [°]", 180 / numpy.pi),
           ("length", "length [px]", 1.0))
_STATES = (("locked", style.BLUE), ("coasting", style.SKY), ("lost", style.VERMILLION), ("detecting", style.PALE))


def draw(recording: Recording) -> Figure:
    names = [name for column, _, _ in _PANELS for name in (column, f"{column}_sd")]
    table = recording.table("track.csv", "no image was looked at", ["time", "track", *names], ["state", "problem"])
    used = numpy.isfinite(table.numbers["time"])
    if not used.all():
        recording.note(f"{table.path}: {int((~used).sum())} of {len(table)} images were not used and are not drawn")
    states = numpy.array(table.texts["state"], dtype=object)
    followed = used & numpy.isin(states, TRACKED)
    if not followed.any():
        raise Missing(f"no pipe was tracked in the {len(table)} images of {table.path}")
    times = table.numbers["time"][used]
    time = TimeAxis(float(times.min()), float(times.max()))
    figure = style.figure(4.0)
    panels = figure.subplots(len(_PANELS) + 1, 1, sharex=True, height_ratios=[1] * len(_PANELS) + [0.3])
    for axes, (column, label, factor) in zip(panels, _PANELS):
        _draw(axes, time, table, column, factor, followed)
        axes.set_ylabel(label)
    _draw_states(panels[-1], time, times, states[used])
    time.limit(panels[-1])
    panels[-1].set_xlabel(time.label)
    figure.align_ylabels(panels)
    style.legend_above(figure, *style.unique_legend(*panels), 3)
    return figure


def _draw(axes: Axes, time: TimeAxis, table: Table, column: str, factor: float, followed: numpy.ndarray) -> None:
    """A track has a line of its own: another one may be of another pipe."""
    for number in numpy.unique(table.numbers["track"][followed]):
        rows = followed & (table.numbers["track"] == number)
        stamps = table.numbers["time"][rows]
        values = table.numbers[column][rows]
        if column == "angle":
            values = numpy.unwrap(values, period=numpy.pi)  # of an axis
        values, band = factor * values, 2 * factor * table.numbers[f"{column}_sd"][rows]
        time.band(axes, stamps, values - band, values + band, color=style.PALE_BLUE, label="±2σ as stated")
        time.line(axes, stamps, values, color=style.BLUE, label="estimate")


def _draw_states(axes: Axes, time: TimeAxis, times: numpy.ndarray, states: numpy.ndarray) -> None:
    widths = numpy.diff(time(times), append=time(numpy.array([time.end])))
    for state, colour in _STATES:
        rows = states == state
        if rows.any():
            axes.broken_barh(list(zip(time(times)[rows], widths[rows])), (0, 1), color=colour, linewidth=0,
                             label=state)
    axes.set_yticks([0.5], ["state"])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(0, 1)
