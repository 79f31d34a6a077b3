# SPDX-License-Identifier: Apache-2.0
"""The rack from above with the path of the vehicle over it."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from .. import style
from ..decimation import decimate
from ..ellipses import draw_ellipses
from ..findings import draw_findings, read_findings
from ..labels import Label, place_labels
from ..recording import Missing, Recording
from ..time_axis import pieces
from .flight_data import MISSING_FOR, Poses, read_poses, read_servo, read_truth_if_any
from .rack_file import Rack, read_rack

PIPE = "#D9DEE2"
PIPE_ABOVE = "#C3CBD1"
EDGE = "#7C868E"
SUPPORT = "#EDE3D2"
MARGIN = 0.6
"""Metres around rack and path."""
FROM_ABOVE = (1, 0)
"""y to the right, x down."""
ELLIPSE = 0.2
"""Metres, the radius that the usual ellipse is drawn with."""


def draw(recording: Recording) -> Figure:
    servo = read_servo(recording)
    poses = servo.vehicle(read_poses(recording))
    truth = read_truth_if_any(recording)
    try:
        rack = read_rack(recording)
    except Missing as reason:
        recording.note(f"map is drawn without the rack: {reason}")
        rack = Rack([])
    low, high = extent(rack, poses, servo.way_points)
    width = style.COLUMN - 0.55
    height = width * (high[0] - low[0]) / (high[1] - low[1])
    figure = style.figure(height + style.LABELS)
    axes = figure.subplots()
    draw_rack(axes, rack)
    if truth is not None:
        draw_path(axes, servo.vehicle(truth), color=style.BLACK, linewidth=0.5, linestyle=(0, (1.2, 2.2)), zorder=6,
                  label="true")
    draw_path(axes, poses, color=style.BLUE, linewidth=1.0, zorder=5, label="estimated")
    draw_ellipses(axes, poses.positions[:, 1::-1], poses.deviations[:, 1::-1], poses.correlation_xy, ELLIPSE)
    draw_way_points(axes, servo.way_points)
    findings = read_findings(recording)
    draw_findings(axes, findings, FROM_ABOVE, "hot spot")
    limit(axes, low, high)
    axes.set_xlabel("along the flow, y [m]")
    axes.set_ylabel("across, x [m]")
    style.legend_above(figure, *style.unique_legend(axes), 3, grow=True)
    place_labels(axes, [*way_point_labels(servo.way_points), *findings.labels(FROM_ABOVE)],
                 findings.marks(FROM_ABOVE))
    return figure


def extent(rack: Rack, poses: Poses, way_points: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Lowest and highest x and y of what is to be seen: the path, and the pipes along y. A pipe across is
    cut off where these end."""
    corners = [poses.positions[:, :2], way_points[:, :2]]
    for pipe in rack.pipes:
        ends = numpy.array([pipe.start[:2], (pipe.start + pipe.length * pipe.direction)[:2]])
        if abs(pipe.direction[0]) > 0.5:
            ends[:, 0] = corners[0][0, 0]
        corners += [ends - pipe.largest_radius, ends + pipe.largest_radius]
    points = numpy.concatenate(corners)
    return points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN


def limit(axes: Axes, low: numpy.ndarray, high: numpy.ndarray) -> None:
    """Seen from above with the flow to the right, x points down."""
    axes.set(xlim=(low[1], high[1]), ylim=(high[0], low[0]), aspect="equal")


def draw_rack(axes: Axes, rack: Rack, names: bool = True) -> None:
    for support in rack.supports:
        size = support.highest - support.lowest
        axes.add_patch(Rectangle((support.lowest[1], support.lowest[0]), size[1], size[0],
                                 facecolor=SUPPORT, edgecolor=EDGE, linewidth=0.3,
                                 zorder=1 + 0.1 * support.highest[2]))
    for pipe in rack.pipes:
        aside = numpy.cross(pipe.direction, [0.0, 0.0, 1.0])
        places = numpy.array([pipe.start + along * pipe.direction for along, _ in pipe.radii])
        radii = numpy.array([[radius] for _, radius in pipe.radii])
        outline = numpy.concatenate((places - radii * aside, (places + radii * aside)[::-1]))
        higher = pipe.start[2] > 2 * pipe.largest_radius
        axes.add_patch(Polygon(outline[:, [1, 0]], facecolor=PIPE_ABOVE if higher else PIPE,
                               edgecolor=EDGE, linewidth=0.4, zorder=2 + 0.1 * float(places[:, 2].max())))
        if names and abs(pipe.direction[1]) > 0.5:
            axes.annotate(pipe.name, (places[0, 1], places[0, 0]), (3, 0), textcoords="offset points",
                          va="center", fontsize=5, color=EDGE, zorder=4)
        elif names:
            axes.annotate(pipe.name, (places[0, 1], 1), (0, -2), xycoords=("data", "axes fraction"),
                          textcoords="offset points", ha="center", va="top", fontsize=5, color=EDGE,
                          zorder=4)


def draw_path(axes: Axes, poses: Poses, **how) -> None:
    for piece in pieces(poses.times, MISSING_FOR):
        points = poses.positions[piece]
        # Thinned by time: each coordinate keeps its extremes.
        kept = numpy.unique(numpy.concatenate([
            decimate(numpy.arange(len(points)), points[:, k], style.GROUPS)[0] for k in (0, 1)]))
        axes.plot(points[kept, 1], points[kept, 0], **how)


def draw_way_points(axes: Axes, way_points: numpy.ndarray) -> None:
    if not len(way_points):
        return
    axes.plot(way_points[:, 1], way_points[:, 0], "o", color=style.VERMILLION, markerfacecolor="white",
              markersize=4, markeredgewidth=0.8, zorder=8, label="way-point")


def way_point_labels(way_points: numpy.ndarray) -> list[Label]:
    """Their numbers; of those at one place, together."""
    numbers: dict[tuple[float, float], list[str]] = {}
    for number, (x, y) in enumerate(way_points[:, :2].tolist(), 1):
        numbers.setdefault((x, y), []).append(str(number))
    return [Label(y, x, ", ".join(texts), style.VERMILLION) for (x, y), texts in numbers.items()]
