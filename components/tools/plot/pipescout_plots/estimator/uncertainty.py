# SPDX-License-Identifier: Apache-2.0
"""Height, and the stated standard deviation of the position, over time."""

from __future__ import annotations

import numpy
from matplotlib.figure import Figure

from .. import style
from ..recording import Recording
from .run_data import read_estimates, time_of_run

_SHOWN = 0.9
"""Of the bands about the height that the axis shows: the widest are of the start."""
_AXES = (("x", style.BLUE), ("y", style.VERMILLION), ("z", style.GREEN))


def draw(recording: Recording) -> Figure:
    run = read_estimates(recording)
    time = time_of_run(recording, run.times)
    figure = style.figure(2.6)
    height, deviation = figure.subplots(2, 1, sharex=True)
    z, band = run.positions[:, 2], 2 * run.deviations[:, 2]
    time.band(height, run.times, z - band, z + band, color=style.PALE_BLUE, label="±2σ of z")
    time.line(height, run.times, z, color=style.GREEN)
    usual = float(numpy.nanquantile(band, _SHOWN))
    height.set_ylim(z.min() - 1.1 * usual, z.max() + 1.1 * usual)
    height.set_ylabel("z, up [m]")
    for column, (name, colour) in enumerate(_AXES):
        time.line(deviation, run.times, run.deviations[:, column], color=colour, label=name)
    style.log_axis(deviation)
    deviation.set_ylabel("standard\ndeviation [m]")
    time.limit(deviation)
    deviation.set_xlabel(time.label)
    figure.align_ylabels()
    style.legend_above(figure, *style.unique_legend(deviation, height), 4)
    return figure
