# SPDX-License-Identifier: Apache-2.0
"""Where the robot was, seen from above: estimate, truth, uncertainty, and the fixes that GPS gave."""

from __future__ import annotations

from dataclasses import dataclass

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
UNKNOWN = "of unknown outcome"
"""Without factors.csv."""
FIXES = {  # outcome: colour, marker
    UNKNOWN: (style.SKY, "."),
    "accepted": (style.GREEN, "."),
    "gated": (style.VERMILLION, "x"),
    "not used": (style.GREY, "+"),
}
LARGEST_HEIGHT = 4.5
"""Inches."""


def draw(recording: Recording) -> Figure:
    estimates = read_estimates(recording)
    true_times, truth = read_true_positions(recording)
    fixes = read_fixes(recording)
    low, high = frame(estimates.positions, truth, fixes)
    size = float((high - low).max())
    width = style.COLUMN - 0.55
    height = min(width * float((high[1] - low[1]) / (high[0] - low[0])), LARGEST_HEIGHT)
    figure = style.figure(height + style.LABELS)
    axes = figure.subplots()
    _draw_fixes(axes, recording, fixes, low, high)
    _draw_path(axes, estimates.times, estimates.positions, color=style.BLUE, linewidth=1.0, zorder=5,
               label="estimated")
    if len(truth):
        _draw_path(axes, true_times, truth, color=style.BLACK, linewidth=0.6, linestyle=(0, (1.2, 2.2)),
                   zorder=6, label="true")
    draw_ellipses(axes, estimates.positions[:, :2], estimates.deviations[:, :2],
                  estimates.correlation_xy, 0.022 * size)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x [m]",
             ylabel="y [m]")
    style.legend_above(figure, *style.unique_legend(axes), 2, grow=True)
    return figure


def frame(estimated: numpy.ndarray, truth: numpy.ndarray, fixes: Fixes | None) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Of the panel, around the path and all fixes that were accepted: what the estimate was made of belongs to
    it. Others that are farther off would make a dot of the path."""
    seen = [estimated[:, :2], truth[:, :2]]
    if fixes is not None:
        seen.append(fixes.places[(fixes.outcomes == "accepted") & numpy.isfinite(fixes.places).all(axis=1)])
    points = numpy.concatenate(seen)
    low, high = points.min(axis=0), points.max(axis=0)
    return _framed(low, high, max(float((high - low).max()), 0.1))


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


@dataclass
class Fixes:
    places: numpy.ndarray
    """(n, 2)"""
    outcomes: numpy.ndarray
    """Of FIXES."""


def read_fixes(recording: Recording) -> Fixes | None:
    """Raises BadData."""
    try:
        table = recording.table("gps.csv", "no fix arrived", ["stamp", "x", "y"])
    except Missing:
        return None
    places = numpy.stack((table.numbers["x"], table.numbers["y"]), axis=-1)
    return Fixes(places, _outcomes(recording, table.numbers["stamp"]))


def _draw_fixes(axes: Axes, recording: Recording, fixes: Fixes | None, low: numpy.ndarray,
                high: numpy.ndarray) -> None:
    """Those beyond the panel are counted, with how far the farthest is from it."""
    if fixes is None:
        return
    distances = numpy.linalg.norm(numpy.maximum(numpy.maximum(low - fixes.places, fixes.places - high), 0), axis=1)
    for outcome, (colour, marker) in FIXES.items():
        rows = fixes.outcomes == outcome
        outside = rows & (distances > 0)
        if rows.any():
            label = f"GPS {outcome}" if outcome != UNKNOWN else "GPS fix"
            if outside.any():
                label += f" ({outside.sum()} of {rows.sum()} outside, up to {distances[outside].max():.3g} m)"
            axes.plot(*fixes.places[rows & (distances == 0)].T, marker, color=colour, markersize=3.5,
                      markeredgewidth=0.7, linestyle="", zorder=4, label=label)
    if numpy.mean(distances > 0) > 0.5:
        recording.note(f"{int((distances > 0).sum())} of {len(distances)} GPS fixes lie outside of the trajectory's "
                       "panel: either GPS was wrong for most of the time, or gps.csv is in another frame than the estimate")


def _outcomes(recording: Recording, stamps: numpy.ndarray) -> numpy.ndarray:
    """Of fixes at these stamps; "not used" for what no factor tells of."""
    factors = read_factors_if_any(recording)
    if factors is None:
        return numpy.full(len(stamps), UNKNOWN, dtype=object)
    result = numpy.full(len(stamps), "not used", dtype=object)
    rows = numpy.flatnonzero(factors.kinds == "gps")
    if rows.size:
        rows = rows[numpy.argsort(factors.times[rows], kind="stable")]
        row_of, known = nearest(factors.times[rows], stamps)
        told = factors.outcomes[rows][row_of]
        known &= numpy.isin(told, ("accepted", "gated"))
        result[known] = told[known]
    return result
