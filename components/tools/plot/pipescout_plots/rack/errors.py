# SPDX-License-Identifier: Apache-2.0
"""Errors of the pose over time beside what it says of itself (the paper's Figure 7)."""

from __future__ import annotations

import numpy
from matplotlib.figure import Figure

from .. import style
from ..error_panel import draw_error
from ..recording import Missing, Recording
from . import rotations
from .flight_data import Poses, read_poses, read_truth
from .timeline import Timeline

_PANELS = ("across", "along", "up", "about across", "about along", "about up")


def draw(recording: Recording) -> Figure:
    poses = read_poses(recording)
    truth = read_truth(recording)
    error = pose_errors(poses, truth)
    if not numpy.isfinite(error).any():
        raise Missing(f"{recording.folder / 'pose.csv'} has no pose within the time of truth.csv")
    timeline = Timeline(recording, min(poses.times[0], truth.times[0]),
                        max(poses.times[-1], truth.times[-1]))
    figure = style.figure(3.5)
    grid = figure.subplots(3, 2, sharex=True)
    for k, axes in enumerate(grid.T.flat):
        factor = 1000.0 if k < 3 else 180 / numpy.pi
        draw_error(axes, timeline, poses.times, factor * error[:, k], factor * poses.deviations[:, k])
        timeline.mark(axes, numbers=k % 3 == 0)
        axes.set_ylabel(f"{_PANELS[k]} [{'mm' if k < 3 else '°'}]", labelpad=1)
    for axes in grid[-1]:
        axes.set_xlabel(timeline.label)
    for column in grid.T:
        figure.align_ylabels(column)
    for axes, letter, what in zip(grid[0], "ab", ("error of the position", "error of the orientation")):
        axes.annotate(f"({letter}) {what}", (0, 1), (-27, 9), xycoords="axes fraction",
                      textcoords="offset points")
    style.legend_above(figure, *style.unique_legend(*grid.flat), 4)
    return figure


def pose_errors(poses: Poses, truth: Poses) -> numpy.ndarray:
    """(n, 6): estimate minus truth in the rack frame, metres; and the rotation from the true to the
    estimated orientation about the axes of the rack, radians. NaN where there is no truth."""
    true_rotations = truth.rotations_at(poses.times)
    turn = poses.rotations @ numpy.swapaxes(true_rotations, -1, -2)
    return numpy.concatenate((poses.positions - truth.positions_at(poses.times),
                              rotations.logarithm(turn)), axis=-1)
