# SPDX-License-Identifier: Apache-2.0
"""Errors of the pose over time beside what it says of itself (the paper's Figure 7)."""

from __future__ import annotations

import numpy
from matplotlib.figure import Figure

from .. import style
from ..recording import Missing, Recording
from . import rotations
from .flight_data import Poses, read_poses, read_truth
from .timeline import Timeline, unique_legend

_PANELS = ("across", "along", "up", "about across", "about along", "about up")


def draw(recording: Recording) -> Figure:
    poses = read_poses(recording)
    truth = read_truth(recording)
    error = pose_errors(poses, truth)
    if not numpy.isfinite(error).any():
        raise Missing(f"{recording.folder / 'pose.csv'} has no pose of a time of truth.csv")
    timeline = Timeline(recording, min(poses.times[0], truth.times[0]),
                        max(poses.times[-1], truth.times[-1]))
    figure = style.figure(3.5)
    grid = figure.subplots(3, 2, sharex=True)
    for k, axes in enumerate(grid.T.flat):
        factor = 1000.0 if k < 3 else 180 / numpy.pi
        _draw(axes, timeline, poses.times, factor * error[:, k], factor * poses.deviations[:, k])
        timeline.mark(axes, numbers=k % 3 == 0)
        axes.set_ylabel(f"{_PANELS[k]} [{'mm' if k < 3 else '°'}]", labelpad=1)
        axes.locator_params(axis="y", nbins=5)
    for axes in grid[-1]:
        axes.set_xlabel(timeline.label)
    for column in grid.T:
        figure.align_ylabels(column)
    for axes, letter, what in zip(grid[0], "ab", ("position", "orientation")):
        axes.annotate(f"({letter}) {what}", (0, 1), (-27, 9), xycoords="axes fraction",
                      textcoords="offset points")
    style.legend_above(figure, *unique_legend(*grid.flat), 4)
    return figure


def pose_errors(poses: Poses, truth: Poses) -> numpy.ndarray:
    """(n, 6): estimate minus truth in the rack frame, metres; and the rotation from the true to the
    estimated orientation about the axes of the rack, radians. NaN where there is no truth."""
    true_rotations = truth.rotations_at(poses.times)
    turn = poses.rotations @ numpy.swapaxes(true_rotations, -1, -2)
    return numpy.concatenate((poses.positions - truth.positions_at(poses.times),
                              rotations.logarithm(turn)), axis=-1)


def _draw(axes, timeline: Timeline, stamps: numpy.ndarray, error: numpy.ndarray,
          deviation: numpy.ndarray) -> None:
    timeline.band(axes, stamps, -2 * deviation, 2 * deviation, color=style.PALE_BLUE,
                  label="±2σ as stated")
    axes.axhline(0, color=style.BLACK, linewidth=0.4)
    timeline.line(axes, stamps, error, color=style.BLUE, linewidth=0.6, label="error")
    usual = numpy.concatenate((_usual(error, 0.99), 2 * _usual(deviation, 0.98)))
    limit = style.symmetric_limit(usual, 1.2)
    axes.set_ylim(-limit, limit)
    beyond = numpy.abs(error) > limit
    if beyond.any():
        axes.plot(timeline(stamps[beyond]), numpy.sign(error[beyond]) * 0.95 * limit, ".",
                  color=style.VERMILLION, markersize=3.5, markeredgewidth=0, label="error beyond the axis")


def _usual(values: numpy.ndarray, share: float) -> numpy.ndarray:
    """What all but the few frames after a start or a loss keep below."""
    finite = numpy.abs(values[numpy.isfinite(values)])
    return numpy.quantile(finite, [share]) if finite.size else finite
