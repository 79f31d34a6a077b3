# SPDX-License-Identifier: Apache-2.0
"""Table I of the paper as a picture: errors by the number of pipes and of texture points."""

from __future__ import annotations

import math
import re

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator, ScalarFormatter

from .. import style
from ..recording import Missing, Recording
from ..reproduction import number_of, read_rows
from .timeline import unique_legend

STUDY = re.compile(r"Table I:.*?(\d+) samples an edge")
"""In the name of a study, with the samples that each edge gave."""
MEASURES = (("position", "m", "position [cm]", 100.0), ("orientation", "deg", "orientation [°]", 1.0))
OURS = ((style.BLUE, "o"), (style.GREEN, "^"))


def draw(recording: Recording) -> Figure:
    studies = cells(read_rows(recording.mission))
    if not studies:
        raise Missing(f"{recording.mission} has no rows of Table I")
    pipes = sorted({cell["pipes"] for study in studies.values() for cell in study})
    figure = style.figure(2.9)
    grid = figure.subplots(2, len(pipes), sharex=True, sharey="row", squeeze=False)
    for row, (quantity, unit, label, factor) in zip(grid, MEASURES):
        for axes, number in zip(row, pipes):
            for order, (samples, study) in enumerate(studies.items()):
                shown = sorted((cell for cell in study if cell["pipes"] == number),
                               key=lambda cell: cell["points"])
                if order == 0:
                    _draw_paper(axes, shown, quantity, unit, factor)
                _draw_ours(axes, shown, quantity, unit, factor, f"{samples} samples",
                           OURS[order])
            _scale(axes)
        row[0].set_ylabel(label)
    for axes, number in zip(grid[0], pipes):
        axes.set_title(f"{number:.0f} pipes", pad=3)
    for axes in grid[-1]:
        axes.set_xticks([10, 30, 50])
    figure.supxlabel("texture points", fontsize=7)
    figure.align_ylabels()
    style.legend_above(figure, *_legend(grid))
    return figure


def _legend(grid: numpy.ndarray) -> tuple[list, list[str], int]:
    """The paper in a column of its own; an empty place below it keeps the others in pairs."""
    handles, labels = unique_legend(*grid.flat)
    blank = grid[0, 0].plot([], [], linestyle="none")[0]
    return [handles[0], blank, *handles[1:]], [labels[0], " ", *labels[1:]], (len(labels) + 2) // 2


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


def _draw_ours(axes: Axes, shown: list[dict], quantity: str, unit: str, factor: float, samples: str,
               look: tuple[str, str]) -> None:
    colour, marker = look
    points = [cell["points"] for cell in shown]
    values = factor * numpy.array([cell[f"{quantity}_{unit}"] for cell in shown])
    spread = factor * numpy.array([cell.get(f"{quantity}_{unit}_sd", math.nan) for cell in shown])
    bound = [factor * cell.get(f"{quantity}_bound_rms_{unit}", math.nan) for cell in shown]
    axes.fill_between(points, values - spread, values + spread, color=colour, alpha=0.2, linewidth=0)
    axes.plot(points, values, color=colour, marker=marker, markersize=2.5, label=f"ours, {samples}")
    axes.plot(points, bound, color=colour, linewidth=0.6, linestyle=(0, (3, 2)),
              label=f"bound, {samples}")


def _scale(axes: Axes) -> None:
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(ScalarFormatter())
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="y", color=style.PALE, linewidth=0.5)
    axes.set_axisbelow(True)
