# SPDX-License-Identifier: Apache-2.0
"""What the estimator holds the sensors' own errors for, over time."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from .. import style
from ..csv_table import Table
from ..recording import Missing, Recording
from ..time_axis import TimeAxis
from .run_data import read_states, time_of_run

_AXES = (("x", style.BLUE), ("y", style.VERMILLION), ("z", style.GREEN))
_BIASES = (("gyro_bias", "gyro bias [mrad/s]", 1e3), ("accelerometer_bias", "accelerometer\nbias [m/s²]", 1.0))
_SCALE = "odometer_scale"


def draw(recording: Recording) -> Figure:
    names = [f"{bias}_{axis}" for bias, _, _ in _BIASES for axis, _ in _AXES] + [_SCALE]
    states = read_states(recording, [*names, *(f"{name}_standard_deviation" for name in names)], [])
    if not any(numpy.isfinite(states.numbers[name]).any() for name in names):
        raise Missing(f"{states.path} has no state of a running estimator")
    time = time_of_run(recording, states.numbers["stamp"])
    with_scale = bool(numpy.isfinite(states.numbers[_SCALE]).any())
    figure = style.figure(2.7 + 0.9 * with_scale)
    panels = figure.subplots(2 + with_scale, 1, sharex=True)
    for axes, (bias, label, factor) in zip(panels, _BIASES):
        _draw(axes, time, states, [(f"{bias}_{axis}", colour, axis) for axis, colour in _AXES], factor)
        axes.axhline(0, color=style.BLACK, linewidth=0.4)
        axes.set_ylabel(label)
    if with_scale:
        states.numbers[_SCALE] = states.numbers[_SCALE] - 1
        _draw(panels[2], time, states, [(_SCALE, style.BLACK, "odometer")], 100.0)
        panels[2].set_ylabel("odometer scale\nabove 1 [%]")
    time.limit(panels[-1])
    panels[-1].set_xlabel(time.label)
    figure.align_ylabels(panels)
    handles, labels = style.unique_legend(*panels)
    style.legend_above(figure, [*handles, Patch(color=style.PALE_GREY)], [*labels, "±2σ"], 5)
    return figure


def _draw(axes: Axes, time: TimeAxis, states: Table, lines: list[tuple[str, str, str]], factor: float) -> None:
    """`lines`: column, colour, label. The axis shows all values, and the bands but for their widest tenth,
    which is the start."""
    stamps = states.numbers["stamp"]
    edges = []
    for name, colour, label in lines:
        values = factor * states.numbers[name]
        band = 2 * factor * states.numbers[f"{name}_standard_deviation"]
        time.band(axes, stamps, values - band, values + band, color=colour, alpha=0.2)
        time.line(axes, stamps, values, color=colour, label=label)
        known = numpy.isfinite(values) & numpy.isfinite(band)
        if known.any():
            usual = numpy.quantile(band[known], 0.9)
            edges += [values[known].min() - usual, values[known].max() + usual]
    if edges and max(edges) > min(edges):
        margin = 0.05 * (max(edges) - min(edges))
        axes.set_ylim(min(edges) - margin, max(edges) + margin)
