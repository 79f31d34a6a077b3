# SPDX-License-Identifier: Apache-2.0
"""The leaks that were found: from above, where their places are known, and by their temperatures."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .. import style
from ..csv_table import Table
from ..labels import Label, place_labels
from ..recording import Recording
from .severity import COLOURS

LARGEST_HEIGHT = 3.5
"""Inches, of the view from above."""
LEAST_EXTENT = 2.0
"""m: of the view from above, about a single leak."""
MARGIN = 0.12
"""Of the extent, about the leaks."""


def draw(recording: Recording) -> Figure:
    table = recording.table("leaks.csv", "no leak was looked for", [
        "id", "mean_delta_k", "mean_delta_low_k", "mean_delta_high_k", "peak_delta_k", "map_x", "map_y",
        "map_x_deviation", "map_y_deviation"], ["state", "severity"])
    placed = numpy.isfinite(table.numbers["map_x"]) & numpy.isfinite(table.numbers["map_y"])
    if not placed.any():
        recording.note("leaks are not drawn from above: no place of one is known; images with poses have places")
    elif not placed.all():
        recording.note(f"leaks without a known place are not drawn from above: {int((~placed).sum())} of {len(table)}")
    low, high = _frame(table, placed) if placed.any() else (numpy.zeros(2), numpy.ones(2))
    view = min((style.COLUMN - 0.55) * float((high[1] - low[1]) / (high[0] - low[0])), LARGEST_HEIGHT)
    heights = [view, 1.5] if placed.any() else [1.5]
    figure = style.figure(sum(heights) + style.LABELS * len(heights))
    panels = numpy.atleast_1d(figure.subplots(len(heights), 1, height_ratios=heights))
    _draw_temperatures(panels[-1], table)
    if placed.any():
        _draw_places(panels[0], table, placed)
        panels[0].set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    style.legend_above(figure, *_ordered(*style.unique_legend(*panels[::-1])), 4, grow=True)
    if placed.any():
        place_labels(panels[0], [
            Label(x, y, f"{number:.0f}", style.BLACK) for number, x, y in
            zip(*(table.numbers[name][placed].tolist() for name in ("id", "map_x", "map_y")))])
    return figure


def _frame(table: Table, placed: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
    places = numpy.stack([table.numbers[name][placed] for name in ("map_x", "map_y")])
    low, high = places.min(axis=1), places.max(axis=1)
    extent = max(float((high - low).max()), LEAST_EXTENT)
    middle, half = (low + high) / 2, (high - low) / 2 + MARGIN * extent
    half = numpy.maximum(half, [half[1] / 2, half[0] / 4])
    return middle - half, middle + half


def _draw_places(axes: Axes, table: Table, placed: numpy.ndarray) -> None:
    x, y = table.numbers["map_x"][placed], table.numbers["map_y"][placed]
    axes.errorbar(x, y, 2 * table.numbers["map_y_deviation"][placed], 2 * table.numbers["map_x_deviation"][placed],
                  fmt="none", ecolor=style.PALE_GREY, elinewidth=1.2, zorder=2, label="±2σ of the place")
    for severity, rows, hollow in _groups(table, placed):
        colour = COLOURS.get(severity, style.GREY)
        axes.plot(table.numbers["map_x"][rows], table.numbers["map_y"][rows], "o", color=colour, markersize=4.5,
                  markerfacecolor="white" if hollow else colour, markeredgewidth=0.9, linestyle="", zorder=3,
                  label=f"{severity}, cleared" if hollow else severity)


def _draw_temperatures(axes: Axes, table: Table) -> None:
    everything = numpy.ones(len(table), dtype=bool)
    number, mean = table.numbers["id"], table.numbers["mean_delta_k"]
    known = numpy.isfinite(table.numbers["mean_delta_low_k"]) & numpy.isfinite(table.numbers["mean_delta_high_k"])
    axes.vlines(number[known], table.numbers["mean_delta_low_k"][known], table.numbers["mean_delta_high_k"][known],
                color=style.PALE_GREY, linewidth=2.5, zorder=1, label="95 % of the mean")
    axes.plot(number, table.numbers["peak_delta_k"], "_", color=style.BLACK, markersize=6, markeredgewidth=0.9,
              linestyle="", zorder=3, label="peak")
    for severity, rows, hollow in _groups(table, everything):
        colour = COLOURS.get(severity, style.GREY)
        axes.plot(number[rows], mean[rows], "o", color=colour, markersize=4.5,
                  markerfacecolor="white" if hollow else colour, markeredgewidth=0.9, linestyle="", zorder=2,
                  label=f"{severity}, cleared" if hollow else severity)
    axes.axhline(0, color=style.BLACK, linewidth=0.4)
    axes.set_xlim(number.min() - 0.7, number.max() + 0.7)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=14))
    axes.set_xlabel("number of the leak")
    axes.set_ylabel("above sound pipe [K]")


def _groups(table: Table, among: numpy.ndarray):
    """Of the same severity, and cleared or not: severity, rows, whether cleared."""
    severities = numpy.array(table.texts["severity"], dtype=object)
    cleared = numpy.array(table.texts["state"], dtype=object) == "cleared"
    names = [*COLOURS, *sorted(set(table.texts["severity"]) - set(COLOURS))]
    for severity in names:
        for hollow in (False, True):
            rows = among & (severities == severity) & (cleared == hollow)
            if rows.any():
                yield severity, rows, hollow


def _ordered(handles: list, labels: list[str]) -> tuple[list, list[str]]:
    """Severities first."""
    order = sorted(range(len(labels)), key=lambda k: labels[k].split(",")[0] not in COLOURS)
    return [handles[k] for k in order], [labels[k] for k in order]
