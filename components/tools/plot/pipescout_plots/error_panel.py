# SPDX-License-Identifier: Apache-2.0
"""An error over time beside what the estimate says of itself."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes

from . import style
from .time_axis import TimeAxis


def draw_error(axes: Axes, time: TimeAxis, stamps: numpy.ndarray, error: numpy.ndarray,
               deviation: numpy.ndarray) -> None:
    """The axis shows the band but for the widest 2 % of the time, and the errors but for the largest 1 %."""
    time.band(axes, stamps, -2 * deviation, 2 * deviation, color=style.PALE_BLUE, label="±2σ as stated")
    axes.axhline(0, color=style.BLACK, linewidth=0.4)
    time.line(axes, stamps, error, color=style.BLUE, linewidth=0.6, label="error")
    usual = numpy.concatenate((_usual(error, 0.99), 2 * _usual(deviation, 0.98)))
    limit = style.symmetric_limit(usual, 1.2)
    axes.set_ylim(-limit, limit)
    axes.locator_params(axis="y", nbins=5)
    beyond = numpy.abs(error) > limit
    if beyond.any():
        axes.plot(time(stamps[beyond]), numpy.sign(error[beyond]) * 0.95 * limit, ".",
                  color=style.VERMILLION, markersize=3.5, markeredgewidth=0, label="error outside the axis")


def _usual(values: numpy.ndarray, share: float) -> numpy.ndarray:
    """What all but the few samples after a start or a loss keep below."""
    finite = numpy.abs(values[numpy.isfinite(values)])
    return numpy.quantile(finite, [share]) if finite.size else finite
