# SPDX-License-Identifier: Apache-2.0
"""The model at the estimated pose, drawn over recorded images."""

from __future__ import annotations

from dataclasses import dataclass

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from .. import style
from ..csv_table import Table
from ..recording import Missing, Recording, image_file
from .camera import Camera, read_camera, read_pgm
from .contours import Line, image_lines
from .flight_data import Poses, read_poses
from .rack_file import Rack, read_rack

IMAGES = 3
ZOOM = 44
"""Pixels that a zoom shows in each direction."""
SAME_TIME = 1e-3
"""Seconds between an image and its pose at most: stamps are the same but for rounding."""
VISIBLE = style.ORANGE
HIDDEN = style.SKY


@dataclass
class Images:
    """The recorded images of which there is a pose, and what is needed to draw the model over them."""

    times: numpy.ndarray
    files: list[str]
    rows: numpy.ndarray
    """Of the pose of each."""
    poses: Poses
    camera: Camera
    rack: Rack
    offsets: Table | None

    def __len__(self) -> int:
        return len(self.files)

    def read(self, recording: Recording, number: int) -> numpy.ndarray:
        path = image_file(recording, self.files[number])
        pixels = read_pgm(path)
        if pixels.shape != (self.camera.height, self.camera.width):
            raise Missing(f"{path} differs in size from camera.yaml")
        return pixels

    def lines(self, number: int) -> list[Line]:
        row = self.rows[number]
        return image_lines(self.rack, self._offsets_at(self.times[number]), self.camera,
                           self.poses.positions[row], self.poses.rotations[row])

    def _offsets_at(self, time: float) -> dict[str, float]:
        if self.offsets is None:
            return {}
        rows = numpy.flatnonzero(numpy.abs(self.offsets.numbers["stamp"] - time) < SAME_TIME)
        found = {self.offsets.texts["pipe"][row]: self.offsets.numbers["offset"][row] for row in rows}
        return {name: value for name, value in found.items() if numpy.isfinite(value)}


def read_images(recording: Recording) -> Images:
    """Raises Missing and BadData."""
    images = recording.table("images.csv", "no image was recorded", ["stamp"], ["file"])
    camera = read_camera(recording)
    rack = read_rack(recording)
    poses = read_poses(recording)
    try:
        offsets = recording.table("offsets.csv", "the localizer gave none", ["stamp", "offset"], ["pipe"])
    except Missing as reason:
        recording.note(f"images show the pipes without offsets: {reason}")
        offsets = None
    stamps = images.numbers["stamp"]
    images.require_finite("stamp")
    after = numpy.clip(numpy.searchsorted(poses.times, stamps - SAME_TIME), 0, len(poses.times) - 1)
    kept = numpy.flatnonzero(numpy.abs(poses.times[after] - stamps) < SAME_TIME)
    if not kept.size:
        raise Missing(f"no image of {images.path} has a pose")
    return Images(stamps[kept], [images.texts["file"][row] for row in kept], after[kept], poses, camera,
                  rack, offsets)


def draw(recording: Recording) -> Figure:
    images = read_images(recording)
    shown = numpy.unique(numpy.linspace(0, len(images) - 1, IMAGES + 2).astype(int)[1:-1])
    aspect = images.camera.height / images.camera.width
    width = (style.COLUMN - 0.08) / (1 + aspect)
    figure = style.figure(len(shown) * (width * aspect + 0.16) + 0.16)
    grid = figure.subplots(len(shown), 2, squeeze=False, width_ratios=[1, aspect])
    start = float(images.poses.times[0])
    for (wide, near), number in zip(grid, shown):
        pixels = images.read(recording, number)
        lines = images.lines(number)
        place = zoomed_place(lines, pixels)
        _draw_wide(wide, pixels, lines, place)
        _draw_near(near, pixels, lines, place)
        wide.set_title(f"{images.times[number] - start:.2f} s", loc="left", pad=2)
    grid[0, 1].set_title(f"{ZOOM} × {ZOOM} pixels", loc="left", pad=2)
    handles = [grid[0, 0].plot([], [], color=colour, linewidth=width, linestyle=line)[0]
               for colour, width, line in ((VISIBLE, 0.9, "-"), (HIDDEN, 0.6, (0, (2, 1.5))))]
    style.legend_above(figure, handles, ["model at the estimated pose", "hidden part"], 2)
    return figure


def draw_image(axes: Axes, pixels: numpy.ndarray) -> None:
    height, width = pixels.shape
    axes.imshow(pixels, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), xticks=[], yticks=[])
    axes.spines[:].set_visible(False)


def draw_lines(axes: Axes, lines: list[Line], linewidth: float) -> None:
    for line in lines:
        seen = numpy.where(line.hidden[:, None], numpy.nan, line.pixels)
        behind = numpy.where(line.hidden[:, None], line.pixels, numpy.nan)
        if numpy.isfinite(seen).any():
            axes.plot(*_thinned(seen), color=VISIBLE, linewidth=linewidth, solid_capstyle="butt")
        if numpy.isfinite(behind).any():
            axes.plot(*_thinned(behind), color=HIDDEN, linewidth=0.5 * linewidth,
                      linestyle=(0, (3, 2)))


def _thinned(points: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Points without which the line looks the same: those within a hundredth of a pixel of the line
    between the first and the last of a straight run."""
    finite = numpy.isfinite(points[:, 0])
    kept = finite.copy()
    for piece in numpy.split(numpy.arange(len(points)), numpy.flatnonzero(numpy.diff(finite)) + 1):
        if len(piece) > 2 and finite[piece[0]]:
            start, end = points[piece[0]], points[piece[-1]]
            normal = numpy.array([start[1] - end[1], end[0] - start[0]])
            away = numpy.abs((points[piece] - start) @ normal) / max(float(numpy.linalg.norm(normal)), 1e-9)
            if away.max() < 0.01:
                kept[piece[1:-1]] = False
        elif not finite[piece[0]]:
            kept[piece[0]] = True
    return points[kept, 0], points[kept, 1]


def zoomed_place(lines: list[Line], pixels: numpy.ndarray) -> numpy.ndarray:
    """The point of a line that is seen, wholly inside, where the image changes most across it."""
    height, width = pixels.shape
    grey = pixels.astype(float)
    down, right = numpy.gradient(grey)
    change = numpy.hypot(down, right)
    best, place = -1.0, numpy.array([width / 2, height / 2])
    for line in lines:
        seen = numpy.isfinite(line.pixels[:, 0]) & ~line.hidden
        points = line.pixels[seen]
        inside = ((points >= ZOOM / 2 + 2) & (points <= [width - ZOOM / 2 - 3, height - ZOOM / 2 - 3]))
        points = points[inside.all(axis=1)]
        if not len(points):
            continue
        middle = points[len(points) // 2]
        u, v = numpy.round(middle).astype(int)
        strength = float(change[v - 2:v + 3, u - 2:u + 3].max())
        if strength > best:
            best, place = strength, middle
    return place


def _draw_wide(axes: Axes, pixels: numpy.ndarray, lines: list[Line], place: numpy.ndarray) -> None:
    draw_image(axes, pixels)
    draw_lines(axes, lines, 0.7)
    axes.add_patch(Rectangle(place - ZOOM / 2, ZOOM, ZOOM, fill=False, edgecolor=style.YELLOW, linewidth=0.7,
                             zorder=5))


def _draw_near(axes: Axes, pixels: numpy.ndarray, lines: list[Line], place: numpy.ndarray) -> None:
    draw_image(axes, pixels)
    draw_lines(axes, lines, 0.6)
    axes.set(xlim=(place[0] - ZOOM / 2, place[0] + ZOOM / 2),
             ylim=(place[1] + ZOOM / 2, place[1] - ZOOM / 2))
    axes.spines[:].set_visible(True)
    axes.spines[:].set_color(style.YELLOW)
    axes.spines[:].set_linewidth(0.8)
