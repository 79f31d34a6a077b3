# SPDX-License-Identifier: Apache-2.0
"""What the navigator did over time: speed, deviation from the path, and why it was slow or stood."""

from __future__ import annotations

import numpy
from matplotlib.figure import Figure

from .. import style
from ..recording import Recording
from ..time_axis import TimeAxis

MOST_REASONS = len(style.SEQUENCE)


def draw(recording: Recording) -> Figure:
    table = recording.table("state.csv", "the navigator said nothing",
                            ["stamp", "speed", "lateral_error", "offset"], ["reason", "inspection"])
    table.require_rising("stamp")
    stamps = table.numbers["stamp"]
    time = TimeAxis(stamps[0], stamps[-1])
    figure = style.figure(3.2)
    speed, error, why = figure.subplots(3, 1, sharex=True, height_ratios=(2, 2, 1.6))
    time.line(speed, stamps, table.numbers["speed"], color=style.BLUE)
    speed.axhline(0, color=style.BLACK, linewidth=0.4)
    speed.set_ylabel("speed [m/s]")
    time.line(error, stamps, table.numbers["offset"], color=style.PALE_GREY, linewidth=2, label="offset for an obstacle")
    time.line(error, stamps, table.numbers["lateral_error"], color=style.BLUE, label="lateral error")
    error.set_ylabel("beside path [m]")
    _draw_reasons(why, time, stamps, table.texts["reason"], table.texts["inspection"])
    time.limit(why)
    why.set_xlabel(time.label)
    figure.align_ylabels((speed, error))
    for letter, axes in zip("abc", (speed, error, why)):
        style.label_panel(axes, letter)
    style.legend_above(figure, *style.unique_legend(error), 2)
    return figure


def _draw_reasons(axes, time: TimeAxis, stamps, reasons: list[str], inspections: list[str]) -> None:
    """A line for each, of the most usual ones; that of the inspection in place of a speed limit."""
    told = numpy.array([inspection if reason == "speed limit" and inspection else reason
                        for reason, inspection in zip(reasons, inspections)], dtype=object)
    names, counts = numpy.unique(told[told != ""].astype(str), return_counts=True)
    names = names[numpy.argsort(-counts, kind="stable")][:MOST_REASONS]
    ends = numpy.append(time(stamps)[1:], time(stamps)[-1:])
    for row, name in enumerate(names):
        mine = told == name
        edges = numpy.flatnonzero(numpy.diff(numpy.concatenate(([False], mine, [False])).astype(int)))
        spans = [(time(stamps)[begin], ends[end - 1] - time(stamps)[begin])
                 for begin, end in zip(edges[::2], edges[1::2])]
        axes.broken_barh(spans, (row - 0.4, 0.8), color=style.SEQUENCE[row])
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(max(len(names), 1) - 0.5, -0.5)
