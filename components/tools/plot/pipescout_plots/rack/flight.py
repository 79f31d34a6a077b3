# SPDX-License-Identifier: Apache-2.0
"""Position, orientation and velocities of a flight over time (the paper's Figure 6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import style
from ..recording import Missing, Recording
from . import rotations
from .flight_data import (Commands, Poses, of_images, read_commands, read_poses, read_servo,
                          read_truth_if_any)
from .timeline import Timeline

WINDOW = 0.2
"""Seconds over which velocities are taken from poses."""
COLOURS = (style.BLUE, style.VERMILLION, style.GREEN)
PALE = ("#9CCBEA", "#F4B88F", "#93DBC4")
LABEL_GAP = 0.165
"""Between the labels of lines, of the height of a panel."""


@dataclass(frozen=True)
class Panel:
    quantity: str
    of: str
    """The series of `_series` that it shows."""
    lines: tuple[tuple[int, str], ...]
    """Columns of the series with their labels; colours go by column."""


PANELS = (
    Panel("position [m]", "position", ((0, "x"), (1, "y"), (2, "z"))),
    Panel("yaw [°]", "angles", ((0, "yaw"),)),
    Panel("tilt [°]", "angles", ((1, "pitch"), (2, "roll"))),
    Panel("velocity [m/s]", "linear", ((0, "forward"), (1, "left"), (2, "up"))),
    Panel("rate [°/s]", "angular", ((0, "forward"), (1, "left"), (2, "up"))),
)


def draw(recording: Recording) -> Figure:
    poses = read_poses(recording)
    truth = read_truth_if_any(recording)
    R_camera_base = read_servo(recording).R_base_camera.T
    commands = _commands(recording)
    known = [series for series in (poses, truth) if series is not None]
    timeline = Timeline(recording, min(series.times[0] for series in known),
                        max(series.times[-1] for series in known))
    estimated = _series(poses, R_camera_base)
    true = {} if truth is None else _series(truth, R_camera_base)
    commanded = {} if commands is None else {
        "linear": (commands.times, commands.linear),
        "angular": (commands.times, commands.angular * 180 / numpy.pi)}
    figure = style.figure(5.0)
    axes_of = figure.subplots(len(PANELS), 1, sharex=True, height_ratios=[1.15, 0.75, 0.85, 1, 1])
    for axes, panel, letter in zip(axes_of, PANELS, "abcde"):
        _draw_commanded(axes, timeline, panel, commanded)
        _draw_estimated(axes, timeline, panel, estimated)
        _draw_true(axes, timeline, panel, true)
        timeline.mark(axes, numbers=panel is PANELS[0])
        axes.margins(y=0.08)
        axes.set_ylabel(panel.quantity)
        _label_lines(axes, panel, *estimated[panel.of])
        style.label_panel(axes, letter)
    axes_of[-1].set_xlabel(timeline.label)
    figure.align_ylabels()
    style.legend_above(figure, *style.unique_legend(*axes_of[::-1]), 4)
    return figure


def _commands(recording: Recording) -> Commands | None:
    if of_images(recording):
        return None
    try:
        return read_commands(recording)
    except Missing as reason:
        recording.note(f"flight is drawn without commands: {reason}")
        return None


def _series(poses: Poses, R_camera_base: numpy.ndarray) -> dict[str, tuple[numpy.ndarray, numpy.ndarray]]:
    """Times and (n, 3) values in the unit of the panel."""
    degrees = 180 / numpy.pi
    bases = poses.rotations @ R_camera_base
    angles = numpy.unwrap(rotations.yaw_pitch_roll(bases), axis=0)
    times, linear, angular = velocities(poses, R_camera_base)
    return {"position": (poses.times, poses.positions), "angles": (poses.times, degrees * angles),
            "linear": (times, linear), "angular": (times, degrees * angular)}


def velocities(series: Poses, R_camera_base: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray,
                                                                   numpy.ndarray]:
    """Times, linear (m/s) and angular (rad/s) velocities over WINDOW, in the level frame: the vehicle's
    yaw, z straight up. That is the frame of the commands."""
    times = series.times[(series.times > series.times[0] + WINDOW / 2)
                         & (series.times < series.times[-1] - WINDOW / 2)]
    before, after = times - WINDOW / 2, times + WINDOW / 2
    linear = (series.positions_at(after) - series.positions_at(before)) / WINDOW
    turn = series.rotations_at(after) @ numpy.swapaxes(series.rotations_at(before), -1, -2)
    angular = rotations.logarithm(turn) / WINDOW
    yaw = rotations.yaw_pitch_roll(series.rotations_at(times) @ R_camera_base)[:, 0]
    return times, _levelled(linear, yaw), _levelled(angular, yaw)


def _levelled(vectors: numpy.ndarray, yaw: numpy.ndarray) -> numpy.ndarray:
    cosine, sine = numpy.cos(yaw), numpy.sin(yaw)
    return numpy.stack((cosine * vectors[:, 0] + sine * vectors[:, 1],
                        cosine * vectors[:, 1] - sine * vectors[:, 0], vectors[:, 2]), axis=-1)


def _draw_commanded(axes: Axes, timeline: Timeline, panel: Panel, series: dict) -> None:
    if panel.of not in series:
        return
    times, values = series[panel.of]
    for column, _ in panel.lines:
        # A vehicle that steers its yaw alone is told nothing about the other two.
        if panel.of == "linear" or values[:, column].any():
            timeline.line(axes, times, values[:, column], color=PALE[column], linewidth=1.8, zorder=2,
                          label="commanded")


def _draw_estimated(axes: Axes, timeline: Timeline, panel: Panel, series: dict) -> None:
    times, values = series[panel.of]
    for column, _ in panel.lines:
        timeline.line(axes, times, values[:, column], color=COLOURS[column], zorder=3, label="estimated")


def _draw_true(axes: Axes, timeline: Timeline, panel: Panel, series: dict) -> None:
    if series:
        times, values = series[panel.of]
        for column, _ in panel.lines:
            timeline.line(axes, times, values[:, column], color=style.BLACK, linewidth=0.5,
                          linestyle=(0, (1.2, 2.2)), zorder=4, label="true")


def _label_lines(axes: Axes, panel: Panel, times: numpy.ndarray, values: numpy.ndarray) -> None:
    """At the end of each line, moved apart where they would meet."""
    low, high = axes.get_ylim()
    wanted = []
    for column, text in panel.lines:
        finite = values[numpy.isfinite(values[:, column]), column]
        wanted.append(((float(finite[-1]) - low) / (high - low) if finite.size else 0.5, column, text))
    wanted.sort()
    places = numpy.array([place for place, _, _ in wanted])
    for k in range(1, len(places)):
        places[k] = max(places[k], places[k - 1] + LABEL_GAP)
    places -= max(0.0, float(places.mean() - numpy.mean([place for place, _, _ in wanted])))
    for place, (_, column, text) in zip(places, wanted):
        axes.annotate(text, (1, place), (3, 0), xycoords="axes fraction", textcoords="offset points",
                      va="center", color=COLOURS[column], fontsize=6)
