# SPDX-License-Identifier: Apache-2.0
"""Errors of position and heading over time beside what the estimate says of itself."""

from __future__ import annotations

import numpy
from matplotlib.figure import Figure

from .. import style
from ..error_panel import draw_error
from ..recording import Recording
from .run_data import read_errors, time_of_run

_PANELS = (("x", 0), ("y", 1), ("z", 2), ("heading", 5))
_SMALL = 0.2
"""Metres: errors below are drawn in millimetres."""


def draw(recording: Recording) -> Figure:
    run = read_errors(recording)
    time = time_of_run(recording, run.times)
    figure = style.figure(3.9)
    panels = figure.subplots(len(_PANELS), 1, sharex=True)
    large = numpy.nanquantile(numpy.abs(run.errors[:, :3]), 0.99) > _SMALL
    for axes, (name, column) in zip(panels, _PANELS):
        unit, factor = ("°", 180 / numpy.pi) if name == "heading" else ("m", 1.0) if large else ("mm", 1e3)
        draw_error(axes, time, run.times, factor * run.errors[:, column], factor * run.deviations[:, column])
        axes.set_ylabel(f"{name} error [{unit}]")
    time.limit(panels[-1])
    panels[-1].set_xlabel(time.label)
    figure.align_ylabels(panels)
    style.legend_above(figure, *style.unique_legend(*panels), 3)
    return figure
