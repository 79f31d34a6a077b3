# SPDX-License-Identifier: Apache-2.0
"""A short animation: image with the model over it, and the path over the rack. Always GIF."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from PIL import Image

from .. import style
from ..gif import MOST_FRAMES, write_gif
from ..recording import Missing, Recording
from .flight_data import Poses, read_servo
from .map import PIPE, PIPE_ABOVE, SUPPORT, draw_path, draw_rack, draw_way_points, extent, limit
from .overlay import Images, draw_image, draw_lines, read_images

DPI = 120
"""420 pixels wide."""
DRAWN_WITH = (style.ORANGE, style.SKY, style.BLUE, style.VERMILLION, PIPE, PIPE_ABOVE, SUPPORT)


def write(recording: Recording, path: Path) -> None:
    """Raises Missing, BadData and OSError."""
    images = read_images(recording)
    if len(images) < 2:
        raise Missing("an animation needs two images")
    frames = _frames(recording, images, min(len(images), MOST_FRAMES))
    write_gif(frames, DRAWN_WITH, path)


def _frames(recording: Recording, images: Images, count: int) -> list[Image.Image]:
    servo = read_servo(recording)
    vehicle = servo.vehicle(images.poses)
    low, high = extent(images.rack, vehicle, servo.way_points)
    numbers = numpy.unique(numpy.linspace(0, len(images) - 1, count).astype(int))
    seen = [_seen(images, number) for number in numbers]
    corners = numpy.concatenate([quadrangle for quadrangle in seen if quadrangle is not None] + [[low, high]])
    low, high = corners.min(axis=0), corners.max(axis=0)
    aspect = images.camera.height / images.camera.width
    below = (high[0] - low[0]) / (high[1] - low[1])
    result = []
    for number, quadrangle in zip(numbers, seen):
        figure = Figure(figsize=(style.COLUMN, style.COLUMN * (aspect + below)), dpi=DPI)
        canvas = FigureCanvasAgg(figure)
        share = aspect / (aspect + below)
        upper = figure.add_axes((0, 1 - share, 1, share))
        draw_image(upper, images.read(recording, number))
        draw_lines(upper, images.lines(number), 1.1)
        seconds = images.times[number] - images.poses.times[0]
        upper.annotate(f"{seconds:.1f} s", (0, 1), (4, -4), xycoords="axes fraction",
                       textcoords="offset points", va="top", color="white",
                       bbox={"facecolor": style.BLACK, "pad": 1.5})
        lower = figure.add_axes((0, 0, 1, 1 - share))
        lower.set_axis_off()
        draw_rack(lower, images.rack, names=False)
        draw_way_points(lower, servo.way_points)
        draw_path(lower, _until(vehicle, images.rows[number]), color=style.BLUE, linewidth=1.2, zorder=5)
        if quadrangle is not None:
            lower.add_patch(Polygon(quadrangle[:, ::-1], fill=False, edgecolor=style.ORANGE, linewidth=1.0,
                                    zorder=6))
        lower.plot(*vehicle.positions[images.rows[number], 1::-1], "o", color=style.BLUE, markersize=4,
                   zorder=7)
        limit(lower, low, high)
        canvas.draw()
        result.append(Image.fromarray(numpy.asarray(canvas.buffer_rgba())).convert("RGB"))
    return result


def _until(poses: Poses, row: int) -> Poses:
    return replace(poses, times=poses.times[:row + 1], positions=poses.positions[:row + 1])


def _seen(images: Images, number: int) -> numpy.ndarray | None:
    """Corners (4, 2), x and y in metres, of what the camera sees of the plane on which the pipes rest;
    None when it sees the horizon."""
    row = images.rows[number]
    position = images.poses.positions[row]
    corners = numpy.array([[0, 0, 1], [images.camera.width, 0, 1],
                           [images.camera.width, images.camera.height, 1], [0, images.camera.height, 1]])
    rays = corners @ numpy.linalg.inv(images.camera.matrix).T @ images.poses.rotations[row].T
    if not (rays[:, 2] < -0.1).all():
        return None
    return (position - rays * (position[2] / rays[:, 2])[:, None])[:, :2]
