# SPDX-License-Identifier: Apache-2.0
"""How the arm kept the pipe in view: where it was in the picture, what the arm did, where its joints were."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import style
from ..csv_table import Table
from ..recording import Missing, Recording
from ..time_axis import TimeAxis
from .track_data import ends, read_track, read_truth, section, time_of_mission

_STATES = ("idle", "stowed", "stowing", "fault", "searching", "holding", "tracking")
_WHOLE_PICTURE = 50  # % of the height, from the middle
_LEAST_PICTURE = 10
MOST_JOINTS = len(style.SEQUENCE)


def draw(recording: Recording) -> Figure:
    joints = recording.table("joints.csv", "there is no arm", ["stamp", "position"], ["joint"])
    states = recording.table("arm.csv", "no arm was commanded", ["stamp"], ["state"])
    time = time_of_mission(read_track(recording))
    figure = style.figure(3.9)
    view, state, angles = figure.subplots(3, 1, sharex=True, height_ratios=(3, 2, 3))
    _draw_view(view, time, recording)
    _draw_states(state, time, states)
    draw_joints(angles, time, joints)
    time.limit(angles)
    angles.set_xlabel(time.label)
    figure.align_ylabels((view, state, angles))
    style.legend_above(figure, *style.unique_legend(view, angles), 3)
    return figure


def _draw_view(axes: Axes, time: TimeAxis, recording: Recording) -> None:
    """Between the ends of the pipe's axis, as shares of the height of the picture from its middle."""
    try:
        truth = read_truth(recording)
    except Missing:
        axes.set_visible(False)
        return
    beside = truth.numbers["beside_pipe"] > 0
    stamps = truth.numbers["stamp"][beside]
    height = truth.numbers["height"][beside]
    start, end = ends(section(truth)[beside])
    low, high = (100 * (numpy.stack([start[:, 1], end[:, 1]]) / (height - 1) - 0.5))
    time.band(axes, stamps, numpy.fmin(low, high), numpy.fmax(low, high), color=style.SKY)
    time.line(axes, stamps, (low + high) / 2, color=style.BLACK, linewidth=0.5, label="pipe in the picture")
    axes.axhline(0, color=style.BLACK, linewidth=0.4)
    # The whole picture only where the pipe was all over it.
    farthest = numpy.nanmax(numpy.abs([low, high]), initial=0)
    limit = min(_WHOLE_PICTURE, max(_LEAST_PICTURE, 1.2 * farthest))
    axes.set_ylim(limit, -limit)
    axes.set_ylabel("down [% of height]")


def _draw_states(axes: Axes, time: TimeAxis, states: Table) -> None:
    names = states.texts["state"]
    shown = [name for name in _STATES if name in names]
    levels = numpy.array([shown.index(name) if name in shown else numpy.nan for name in names])
    axes.step(time(states.numbers["stamp"]), levels, where="post", color=style.BLACK, linewidth=0.8)
    axes.set_yticks(range(len(shown)), shown)
    axes.set_ylim(-0.5, len(shown) - 0.5)


def joint_names(joints: Table) -> list[str]:
    return list(dict.fromkeys(joints.texts["joint"]))[:MOST_JOINTS]


def draw_joints(axes: Axes, time: TimeAxis, joints: Table) -> None:
    """Angles from where each joint was at first."""
    names = numpy.array(joints.texts["joint"])
    for name, colour in zip(joint_names(joints), style.SEQUENCE):
        mine = names == name
        positions = joints.numbers["position"][mine]
        time.line(axes, joints.numbers["stamp"][mine], numpy.degrees(positions - positions[0]), color=colour,
                  linewidth=0.7, label=name.removesuffix("_joint").replace("_", " "))
    axes.set_ylabel("joints [°]")
