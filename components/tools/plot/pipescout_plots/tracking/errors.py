# SPDX-License-Identifier: Apache-2.0
"""Errors of the track in x, y, angle and length over time: Figure 8 of Ibarguren and others (2013)."""

from __future__ import annotations

import numpy
from matplotlib.figure import Figure

from .. import style
from ..recording import Recording
from .track_data import read_errors, read_track, time_of_mission

_PANELS = (("x error [px]", 0, 1.0), ("y error [px]", 1, 1.0), ("angle error [°]", 3, 180 / numpy.pi), ("length error [px]", 2, 1.0))
_LINES = (("robust mean", style.PALE_GREY, 0.5), ("best particle", style.SKY, 0.5), ("estimate", style.BLUE, 0.8))
_USUAL = 0.99


def draw(recording: Recording) -> Figure:
    errors = read_errors(recording)
    time = time_of_mission(read_track(recording))
    figure = style.figure(3.9)
    panels = figure.subplots(len(_PANELS), 1, sharex=True)
    for axes, (label, column, factor) in zip(panels, _PANELS):
        shown = []
        for name, colour, width in _LINES:
            values = factor * errors.of[name][:, column]
            time.line(axes, errors.stamps, values, color=colour, linewidth=width, label=name)
            shown.append(numpy.abs(values))
        axes.axhline(0, color=style.BLACK, linewidth=0.4)
        limit = style.symmetric_limit(numpy.array([numpy.quantile(values, _USUAL) for values in shown]), 1.5)
        axes.set_ylim(-limit, limit)
        axes.set_ylabel(label)
    time.limit(panels[-1])
    panels[-1].set_xlabel(time.label)
    figure.align_ylabels(panels)
    style.legend_above(figure, *style.unique_legend(*panels), len(_LINES))
    return figure
