# SPDX-License-Identifier: Apache-2.0
"""Particles and track, drawn over recorded pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from PIL import Image, UnidentifiedImageError

from .. import style
from ..csv_table import BadData, Table
from ..recording import Missing, Recording, image_file
from .track_data import ends, read_track, section, tracked

PICTURES = 3
PARTICLES = 60
"""That are drawn: the heaviest."""


@dataclass
class Pictures:
    """The recorded pictures of which there is a track."""

    stamps: numpy.ndarray
    files: list[str]
    rows: numpy.ndarray
    """Of the track of each."""
    track: Table
    particles: Table | None

    def __len__(self) -> int:
        return len(self.files)

    def read(self, recording: Recording, number: int) -> numpy.ndarray:
        path = image_file(recording, self.files[number])
        try:
            with Image.open(path) as image:
                return numpy.asarray(image.convert("L"))
        except (OSError, UnidentifiedImageError) as problem:
            raise BadData(f"{path}: {problem}") from problem

    def particles_of(self, number: int) -> tuple[numpy.ndarray, numpy.ndarray]:
        """(n, 4) and their weights, the heaviest first."""
        if self.particles is None:
            return numpy.empty((0, 4)), numpy.empty(0)
        mine = numpy.abs(self.particles.numbers["stamp"] - self.stamps[number]) < 1e-6
        weights = self.particles.numbers["weight"][mine]
        order = numpy.argsort(-weights, kind="stable")[:PARTICLES]
        return section(self.particles)[mine][order], weights[order]


def read_pictures(recording: Recording) -> Pictures:
    pictures = recording.table("pictures.csv", "no picture was recorded", ["stamp"], ["file"])
    track = read_track(recording)
    _, mine, rows = numpy.intersect1d(numpy.round(pictures.numbers["stamp"], 6),
                                      numpy.round(track.numbers["stamp"], 6), return_indices=True)
    if len(mine) == 0:
        raise Missing(f"no picture of {pictures.path} has a track")
    particles = None
    if (recording.folder / "particles.csv").is_file():
        particles = recording.table("particles.csv", "", ["stamp", *("u", "v", "length", "angle"), "weight"])
    return Pictures(pictures.numbers["stamp"][mine], [pictures.texts["file"][i] for i in mine], rows, track,
                    particles)


def draw_picture(axes: Axes, pixels: numpy.ndarray) -> None:
    height, width = pixels.shape
    axes.imshow(pixels, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    axes.set_xlim(-0.5, width - 0.5)
    axes.set_ylim(height - 0.5, -0.5)
    axes.set_axis_off()


def draw_track(axes: Axes, pictures: Pictures, number: int) -> None:
    """Particles as short pieces of their axes, the estimate as the edges of the pipe."""
    particles, weights = pictures.particles_of(number)
    if len(particles):
        few = particles.copy()
        few[:, 2] *= 0.15
        start, end = ends(few)
        shade = 0.25 + 0.75 * weights / max(weights.max(), 1e-12)
        axes.add_collection(LineCollection(numpy.stack([start, end], axis=1), colors=style.SKY, alpha=shade,
                                           linewidths=0.5))
        axes.plot(particles[:, 0], particles[:, 1], ".", color=style.YELLOW, markersize=1.4, markeredgewidth=0)
    row = pictures.rows[number]
    if not tracked(pictures.track)[row]:
        return
    estimate = section(pictures.track)[row:row + 1]
    half_width = pictures.track.numbers["half_width"][row]
    across = numpy.array([-numpy.sin(estimate[0, 3]), numpy.cos(estimate[0, 3])])
    start, end = ends(estimate)
    for side in (-1, 1):
        edge = side * (numpy.nan_to_num(half_width) + 1) * across
        axes.plot(*numpy.stack([start[0] + edge, end[0] + edge], axis=1), color=style.ORANGE, linewidth=0.8)


def draw(recording: Recording) -> Figure:
    pictures = read_pictures(recording)
    locked = numpy.flatnonzero(tracked(pictures.track)[pictures.rows])
    if len(locked) == 0:
        raise Missing("the pipe is tracked in none of the recorded pictures")
    chosen = locked[numpy.unique(numpy.linspace(0, len(locked) - 1, PICTURES + 2)[1:-1].astype(int))]
    pixels = [pictures.read(recording, number) for number in chosen]
    height = sum(image.shape[0] / image.shape[1] for image in pixels) * style.COLUMN
    figure = style.figure(height)
    panels = numpy.atleast_1d(figure.subplots(len(chosen), 1))
    for axes, number, image in zip(panels, chosen, pixels):
        draw_picture(axes, image)
        draw_track(axes, pictures, number)
        label = f"{pictures.stamps[number] - pictures.track.numbers['stamp'][0]:.1f} s"
        axes.annotate(label, (0, 1), (4, -4), xycoords="axes fraction", textcoords="offset points", va="top",
                      color="white", bbox={"facecolor": style.BLACK, "pad": 1.5})
    return figure
