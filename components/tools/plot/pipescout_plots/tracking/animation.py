# SPDX-License-Identifier: Apache-2.0
"""A short animation: pictures with particles and track, and the joints of the arm below. Always GIF."""

from __future__ import annotations

from pathlib import Path

import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from .. import style
from ..csv_table import Table
from ..gif import MOST_FRAMES, write_gif
from ..recording import Missing, Recording
from .arm import draw_joints
from .overlay import Pictures, draw_picture, draw_track, read_pictures
from .track_data import time_of_mission

DPI = 120
"""420 pixels wide."""
DRAWN_WITH = (style.ORANGE, style.SKY, style.YELLOW, *style.SEQUENCE)
_BELOW = 1.3
"""Inches: the joints, with their names and the axis of time."""


def write(recording: Recording, path: Path) -> None:
    """Raises Missing, BadData and OSError."""
    pictures = read_pictures(recording)
    if len(pictures) < 2:
        raise Missing("one picture does not move")
    joints = None
    if (recording.folder / "joints.csv").is_file():
        joints = recording.table("joints.csv", "", ["stamp", "position"], ["joint"])
    frames = []
    numbers = numpy.linspace(0, len(pictures) - 1, min(len(pictures), MOST_FRAMES)).astype(int)
    for number in numpy.unique(numbers):
        canvas = draw_frame(recording, pictures, joints, number).canvas
        canvas.draw()
        frames.append(Image.fromarray(numpy.asarray(canvas.buffer_rgba())).convert("RGB"))
    write_gif(frames, DRAWN_WITH, path)


def draw_frame(recording: Recording, pictures: Pictures, joints: Table | None, number: int) -> Figure:
    """Of the picture with this number; raises BadData."""
    pixels = pictures.read(recording, number)
    above = style.COLUMN * pixels.shape[0] / pixels.shape[1]
    height = above + (_BELOW if joints is not None else 0.0)
    share = above / height
    figure = Figure(figsize=(style.COLUMN, height), dpi=DPI)
    FigureCanvasAgg(figure)
    upper = figure.add_axes((0, 1 - share, 1, share))
    draw_picture(upper, pixels)
    draw_track(upper, pictures, number)
    now = pictures.stamps[number]
    label = f"{now - pictures.track.numbers['stamp'][0]:.1f} s  {pictures.track.texts['state'][pictures.rows[number]]}"
    upper.annotate(label, (0, 1), (4, -4), xycoords="axes fraction", textcoords="offset points", va="top",
                   color="white", bbox={"facecolor": style.BLACK, "pad": 1.5})
    if joints is not None:
        time = time_of_mission(pictures.track)
        lower = figure.add_axes((0.14, 0.36 / height, 0.84, (_BELOW - 0.72) / height))
        draw_joints(lower, time, joints)
        lower.axvline(float(time(numpy.array(now))), color=style.BLACK, linewidth=0.8)
        time.limit(lower)
        lower.set_xlabel(time.label, labelpad=1)
        lower.legend(loc="lower center", bbox_to_anchor=(0.45, 1.0), ncols=3, fontsize=5.5, borderaxespad=0.2,
                     labelspacing=0.2)
    return figure
