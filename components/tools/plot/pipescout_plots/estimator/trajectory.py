# SPDX-License-Identifier: Apache-2.0
"""Where the robot was, seen from above: estimate, truth, uncertainty, and the fixes that GPS gave."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import style
from ..decimation import decimate
from ..ellipses import draw_ellipses
from ..recording import Missing, Recording
from ..time_axis import pieces, usual_gap
from .run_data import nearest, read_estimates, read_factors_if_any, read_true_positions

MARGIN = 0.08
"""Of the size of the path, around it."""
FIXES = {  # outcome: colour, marker
    "accepted": (style.GREEN, "."),
    "gated": (style.VERMILLION, "x"),
    "not used": (style.GREY, "+"),
}
LARGEST_HEIGHT = 4.5
"""Inches."""


def draw(recording: Recording) -> Figure:
    estimates = read_estimates(recording)
    true_times, truth = read_true_positions(recording)
    seen = numpy.concatenate((estimates.positions, truth))[:, :2]
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = max(float((high - low).max()), 0.1)
    low, high = _framed(low, high, size)
    width = style.COLUMN - 0.55
    height = min(width * float((high[1] - low[1]) / (high[0] - low[0])), LARGEST_HEIGHT)
    figure = style.figure(height + 0.85)
    axes = figure.subplots()
    _draw_fixes(axes, recording, low, high)
    _draw_path(axes, estimates.times, estimates.positions, color=style.BLUE, linewidth=1.0, zorder=5,
               label="estimated")
    if len(truth):
        _draw_path(axes, true_times, truth, color=style.BLACK, linewidth=0.6, linestyle=(0, (1.2, 2.2)),
                   zorder=6, label="true")
    draw_ellipses(axes, estimates.positions[:, :2], estimates.deviations[:, :2],
                  estimates.correlation_xy, 0.025 * size)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x [m]",
             ylabel="y [m]")
    style.legend_above(figure, *style.unique_legend(axes), 3)
    return figure


def _framed(low: numpy.ndarray, high: numpy.ndarray, size: float) -> tuple[numpy.ndarray, numpy.ndarray]:
    """A path along a line still gets a picture that is a third as high as it is wide."""
    middle, half = (low + high) / 2, (high - low) / 2 + MARGIN * size
    half = numpy.maximum(half, [half[1] / 2, half[0] / 3])
    return middle - half, middle + half


def _draw_path(axes: Axes, times: numpy.ndarray, positions: numpy.ndarray, **how) -> None:
    for piece in pieces(times, usual_gap(times)):
        points = positions[piece]
        # Thinned by time: each coordinate keeps its extremes.
        kept = numpy.unique(numpy.concatenate([
            decimate(numpy.arange(len(points)), points[:, k], style.GROUPS)[0] for k in (0, 1)]))
        axes.plot(points[kept, 0], points[kept, 1], **how)


def _draw_fixes(axes: Axes, recording: Recording, low: numpy.ndarray, high: numpy.ndarray) -> None:
    """Those beyond the panel are counted: one that is 700 m off must not make a dot of the path."""
    try:
        table = recording.table("gps.csv", "no fix arrived", ["stamp", "x", "y"])
    except Missing:
        return
    places = numpy.stack((table.numbers["x"], table.numbers["y"]), axis=-1)
    inside = ((places >= low) & (places <= high)).all(axis=1)
    outcomes = _outcomes(recording, table.numbers["stamp"])
    for outcome, (colour, marker) in FIXES.items():
        rows = outcomes == outcome
        if rows.any():
            beyond = int((rows & ~inside).sum())
            label = f"GPS {outcome}" + (f", {beyond} beyond" if beyond else "")
            axes.plot(*places[rows & inside].T, marker, color=colour, markersize=3.5, markeredgewidth=0.7,
                      linestyle="", zorder=4, label=label)


def _outcomes(recording: Recording, stamps: numpy.ndarray) -> numpy.ndarray:
    """Of fixes at these stamps; "not used" for what no factor tells of."""
    result = numpy.full(len(stamps), "not used", dtype=object)
    factors = read_factors_if_any(recording)
    if factors is None:
        return result
    rows = numpy.flatnonzero(factors.kinds == "gps")
    if rows.size:
        rows = rows[numpy.argsort(factors.times[rows], kind="stable")]
        row_of, known = nearest(factors.times[rows], stamps)
        told = factors.outcomes[rows][row_of]
        known &= numpy.isin(told, ("accepted", "gated"))
        result[known] = told[known]
    return result
