# SPDX-License-Identifier: Apache-2.0
"""Whether the covariance is right: the squared error in its units over time."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import style
from ..recording import Recording
from ..time_axis import TimeAxis
from .run_data import read_errors, time_of_run

# Degrees of freedom, and the quantiles of chi-square at 2.5 % and 97.5 %.
_POSITION = (3, 0.2157952826, 9.3484036045)
_POSE = (6, 1.2373442458, 14.4493753354)
_LEAST = 1e-3
"""What is below is drawn here: a square that is nearly 0 would stretch the axis."""


def draw(recording: Recording) -> Figure:
    run = read_errors(recording)
    time = time_of_run(recording, run.times)
    figure = style.figure(2.7)
    panels = figure.subplots(2, 1, sharex=True)
    for axes, name, nees, quantiles in zip(panels, ("position", "pose"), (run.position_nees, run.pose_nees),
                                           (_POSITION, _POSE)):
        _draw(axes, time, run.times, nees, quantiles)
        axes.set_ylabel(f"NEES of {name} [–]")
    time.limit(panels[-1])
    panels[-1].set_xlabel(time.label)
    figure.align_ylabels(panels)
    style.legend_above(figure, *style.unique_legend(*panels), 3)
    return figure


def _draw(axes: Axes, time: TimeAxis, stamps: numpy.ndarray, nees: numpy.ndarray,
          quantiles: tuple[int, float, float]) -> None:
    degrees, low, high = quantiles
    known = nees[numpy.isfinite(nees)]
    axes.axhspan(low, high, color=style.PALE_BLUE, linewidth=0, zorder=0, label="95 % of a consistent estimator")
    axes.axhline(degrees, color=style.BLACK, linewidth=0.5, linestyle=(0, (3, 2)), label="expected value")
    time.line(axes, stamps, numpy.maximum(nees, _LEAST), color=style.BLUE, linewidth=0.6, label="NEES")
    axes.set_yscale("log")
    bottom, top = axes.get_ylim()
    axes.set_ylim(max(min(bottom, low / 3), _LEAST), max(top, 3 * high))
    if known.size:
        inside = 100 * numpy.mean((known >= low) & (known <= high))
        axes.set_title(f"mean {known.mean():.2f} (expected: {degrees}), {inside:.0f} % in the band", loc="right",
                       pad=2)
