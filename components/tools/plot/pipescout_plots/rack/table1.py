# SPDX-License-Identifier: Apache-2.0
"""Table I of the paper as a picture: errors by the number of pipes and of texture points, and how near
they come to what is possible."""

from __future__ import annotations

import math
import re

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, ScalarFormatter

from .. import style
from ..recording import Missing, Recording
from ..reproduction import number_of, read_rows

STUDY = re.compile(r"Table I:.*?(\d+) samples an edge")
"""In the name of a study, with the samples that each edge gave."""
MEASURES = (("position", "m", "position [cm]", 100.0), ("orientation", "deg", "orientation [°]", 1.0))
OURS = ((style.BLUE, "o"), (style.GREEN, "^"))


def draw(recording: Recording) -> Figure:
    studies = cells(read_rows(recording.file))
    if not studies:
        raise Missing(f"{recording.file} has no rows of Table I")
    pipes = sorted({cell["pipes"] for study in studies.values() for cell in study})
    figure = style.figure(3.7)
    grid = figure.subplots(3, len(pipes), sharex=True, sharey="row", squeeze=False,
                           height_ratios=[1, 1, 0.7])
    for row, (quantity, unit, label, factor) in zip(grid, MEASURES):
        for axes, number in zip(row, pipes):
            for order, (samples, study) in enumerate(studies.items()):
                shown = sorted((cell for cell in study if cell["pipes"] == number),
                               key=lambda cell: cell["points"])
                if order == 0:
                    _draw_paper(axes, shown, quantity, unit, factor)
                _draw_ours(axes, shown, quantity, unit, factor, f"ours, {samples} samples", OURS[order])
            _scale(axes)
        row[0].set_ylabel(label)
    for axes, number in zip(grid[-1], pipes):
        for study, look in zip(studies.values(), OURS):
            _draw_ratio(axes, [cell for cell in study if cell["pipes"] == number], look)
        _scale_ratio(axes)
    grid[-1][0].set_ylabel("error / bound")
    for axes, number in zip(grid[0], pipes):
        axes.set_title(f"{number:.0f} pipes", pad=3)
    for axes in grid[-1]:
        axes.set_xticks([10, 30, 50])
    figure.supxlabel("texture points", fontsize=7)
    figure.align_ylabels()
    handles, labels = style.unique_legend(*grid[0])
    style.legend_above(figure, handles, labels, len(labels))
    return figure


def cells(rows: list[dict]) -> dict[int, list[dict]]:
    """By samples an edge, the fewest first: the cells, whose values are numbers. No more than there are
    colours for."""
    studies: dict[int, list[dict]] = {}
    for row in rows:
        found = STUDY.search(str(row.get("study", "")))
        cell = {name: number_of(value) for name, value in row.items() if name != "study"}
        if found and all(math.isfinite(cell.get(name, math.nan)) for name in
                         ("pipes", "points", "position_m", "orientation_deg")):
            studies.setdefault(int(found[1]), []).append(cell)
    return dict(sorted(studies.items())[:len(OURS)])


def _draw_paper(axes: Axes, shown: list[dict], quantity: str, unit: str, factor: float) -> None:
    axes.plot([cell["points"] for cell in shown],
              [factor * cell.get(f"paper_{quantity}_{unit}", math.nan) for cell in shown],
              color=style.BLACK, marker="s", markersize=2.5, linewidth=0.6, label="paper")


def _draw_ours(axes: Axes, shown: list[dict], quantity: str, unit: str, factor: float, label: str,
               look: tuple[str, str]) -> None:
    colour, marker = look
    points = [cell["points"] for cell in shown]
    values = factor * numpy.array([cell[f"{quantity}_{unit}"] for cell in shown])
    spread = factor * numpy.array([cell.get(f"{quantity}_{unit}_sd", math.nan) for cell in shown])
    axes.fill_between(points, values - spread, values + spread, color=colour, alpha=0.2, linewidth=0)
    axes.plot(points, values, color=colour, marker=marker, markersize=2.5, label=label)


def _draw_ratio(axes: Axes, shown: list[dict], look: tuple[str, str]) -> None:
    """Root mean squares both: the bound says nothing about means."""
    colour, marker = look
    shown = sorted(shown, key=lambda cell: cell["points"])
    axes.plot([cell["points"] for cell in shown], [cell.get("ratio_to_bound", math.nan) for cell in shown],
              color=colour, marker=marker, markersize=2.5)


def _scale_ratio(axes: Axes) -> None:
    """From the bound on, which is 1."""
    axes.axhline(1, color=style.BLACK, linewidth=0.6, linestyle=(0, (3, 2)))
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, 0.98), max(high, 1.1))
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    axes.grid(axis="y", color=style.PALE, linewidth=0.5)
    axes.set_axisbelow(True)


def _scale(axes: Axes) -> None:
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(ScalarFormatter())
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="y", color=style.PALE, linewidth=0.5)
    axes.set_axisbelow(True)
