# SPDX-License-Identifier: Apache-2.0
"""The eddy-current signal over distance with the welds that were found in it."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import style
from .csv_table import Table
from .decimation import decimate
from .recording import Missing, Recording

HALF_WINDOW = 0.25
"""What is shown to each side of a weld, in metres."""
HALF_LOOP = 0.08
"""The part of it that is drawn as the weld's own loop."""
MOST_NAMED = 32
"""Names that there is room for; of more welds only every second, third, ... is named."""

_WHY = "the tables of a crawler have it unless crawler.signal is false"


def draw(recording: Recording) -> Figure:
    samples = recording.table("eddy_current.csv", _WHY, ["stamp", "x1", "y1"])
    fused = recording.table("fused.csv", "without the odometers the signal has no position",
                            ["stamp", "distance"])
    fused.require_rising("stamp")
    known = numpy.isfinite(fused.numbers["distance"])
    if not known.any():
        raise Missing(f"{fused.path} has no valid distance")
    distance = numpy.interp(samples.numbers["stamp"], fused.numbers["stamp"][known],
                            fused.numbers["distance"][known], left=numpy.nan, right=numpy.nan)
    if not numpy.isfinite(distance).any():
        raise Missing(f"{samples.path} has no sample within the time of {fused.path}")
    return _picture(samples, distance, _welds(recording))


def _welds(recording: Recording) -> Table | None:
    columns = ["stamp", "distance", "confidence"]
    try:
        welds = recording.table("welds.csv", "no weld was detected", columns, ["weld_id"])
    except Missing as reason:
        recording.note(f"eddy_current has no welds: {reason}")
        return None
    for column in columns:
        welds.require_finite(column)
    return welds


def _picture(samples: Table, distance: numpy.ndarray, welds: Table | None) -> Figure:
    if welds is None:
        figure = style.figure(1.8)
        axes = figure.subplots()
        _draw_signal(axes, samples, distance)
        axes.set_xlabel("odometer distance [m]")
        style.legend_above(figure, *axes.get_legend_handles_labels(), 2)
        return figure
    figure = style.figure(3.7)
    upper, lower = figure.subfigures(2, 1, height_ratios=[2.1, 1.2])
    signal, confidence = upper.subplots(2, 1, sharex=True, height_ratios=[1.0, 0.9])
    _draw_signal(signal, samples, distance)
    _draw_confidence(confidence, welds)
    confidence.set_xlabel("odometer distance [m]")
    hardest, easiest = zoomed_welds(welds)
    low, high, loop = lower.subplots(1, 3)
    high.sharey(low)
    for axes, weld in ((low, hardest), (high, easiest)):
        _draw_zoom(axes, samples, distance, welds, weld)
    low.set_ylabel("signal [raw]")
    _draw_loop(loop, samples, distance, welds, easiest)
    for axes, letter in zip((signal, confidence, low, high, loop), "abcde"):
        style.label_panel(axes, letter)
    entries = [pair for axes in (signal, confidence) for pair in zip(*axes.get_legend_handles_labels())]
    style.legend_above(figure, [handle for handle, _ in entries], [label for _, label in entries], 4)
    return figure


def zoomed_welds(welds: Table) -> tuple[int, int]:
    """The weld that was hardest to find, and the first of the easiest; a recognised one if there is."""
    confidence = welds.numbers["confidence"]
    named = numpy.array([bool(name) for name in welds.texts["weld_id"]])
    preferred = confidence + named
    return int(numpy.argmin(confidence)), int(numpy.argmax(preferred))


def _draw_signal(axes: Axes, samples: Table, distance: numpy.ndarray) -> None:
    for column, colour in (("x1", style.BLUE), ("y1", style.ORANGE)):
        axes.plot(*decimate(distance, samples.numbers[column], style.GROUPS), color=colour,
                  linewidth=0.5, label=column[0])
    axes.set_ylabel("signal [raw]")
    axes.set_xlim(numpy.nanmin(distance), numpy.nanmax(distance))


def _draw_confidence(axes: Axes, welds: Table) -> None:
    place, confidence = welds.numbers["distance"], welds.numbers["confidence"]
    names = welds.texts["weld_id"]
    named = numpy.array([bool(name) for name in names])
    for rows, filled, label in ((named, style.GREEN, "recognised"), (~named, "white", "not recognised")):
        if rows.any():
            axes.vlines(place[rows], 0, confidence[rows], color=style.GREEN, linewidth=0.6)
            axes.plot(place[rows], confidence[rows], "o", color=style.GREEN, markerfacecolor=filled,
                      markersize=2.5, markeredgewidth=0.6, label=label)
    recognised = numpy.flatnonzero(named)
    for weld in recognised[::-(-len(recognised) // MOST_NAMED) or 1]:
        axes.annotate(names[weld], (place[weld], 1.0), (0, 3), textcoords="offset points", rotation=90,
                      ha="center", va="bottom", fontsize=4.5)
    axes.set_ylabel("confidence", y=0.28)
    axes.set_ylim(0, 1.95)
    axes.set_yticks([0, 0.5, 1])
    axes.spines["left"].set_bounds(0, 1)


def _draw_zoom(axes: Axes, samples: Table, distance: numpy.ndarray, welds: Table, weld: int) -> None:
    rows = _around(samples, distance, welds, weld, HALF_WINDOW)
    place = welds.numbers["distance"][weld]
    for column, colour in (("x1", style.BLUE), ("y1", style.ORANGE)):
        axes.plot(*decimate(distance[rows] - place, samples.numbers[column][rows], style.GROUPS),
                  color=colour, linewidth=0.6)
    axes.axvline(0, color=style.GREEN, linewidth=0.6, linestyle=(0, (4, 2)))
    axes.set_xlim(-HALF_WINDOW, HALF_WINDOW)
    axes.set_xlabel("from the weld [m]")
    axes.set_title(f"{_name(welds, weld)}, {welds.numbers['confidence'][weld]:.2f}", fontsize=6, pad=2)


def _draw_loop(axes: Axes, samples: Table, distance: numpy.ndarray, welds: Table, weld: int) -> None:
    for half, colour, width in ((HALF_WINDOW, style.PALE_GREY, 0.4), (HALF_LOOP, style.BLUE, 0.8)):
        rows = _around(samples, distance, welds, weld, half)
        x, y = samples.numbers["x1"][rows], samples.numbers["y1"][rows]
        axes.plot(x, y, color=colour, linewidth=width)
    if numpy.isfinite(x).any() and numpy.isfinite(y).any():
        reach = 0.55 * max(_span(x), _span(y), 1e-12)
        axes.set_xlim(_middle(x) - reach, _middle(x) + reach)
        axes.set_ylim(_middle(y) - reach, _middle(y) + reach)
    axes.set_aspect("equal")
    axes.set_title(_name(welds, weld), fontsize=6, pad=2)
    axes.set_xlabel("x")
    axes.set_ylabel("y", labelpad=0)


def _span(values: numpy.ndarray) -> float:
    return float(numpy.nanmax(values) - numpy.nanmin(values))


def _middle(values: numpy.ndarray) -> float:
    return float(numpy.nanmax(values) + numpy.nanmin(values)) / 2


def _around(samples: Table, distance: numpy.ndarray, welds: Table, weld: int, half: float) -> slice:
    """The samples within `half` metres of a weld in the passage in which it was found."""
    near = numpy.abs(distance - welds.numbers["distance"][weld]) <= half
    middle = int(numpy.searchsorted(samples.numbers["stamp"], welds.numbers["stamp"][weld]))
    middle = min(middle, len(near) - 1)
    before = numpy.flatnonzero(~near[:middle])
    after = numpy.flatnonzero(~near[middle:])
    start = int(before[-1]) + 1 if before.size else 0
    end = middle + int(after[0]) if after.size else len(near)
    return slice(start, end)


def _name(welds: Table, weld: int) -> str:
    return welds.texts["weld_id"][weld] or f"at {welds.numbers['distance'][weld]:.1f} m"
