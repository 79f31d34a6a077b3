# SPDX-License-Identifier: Apache-2.0
"""A short animation: pictures with particles and track, and the joints of the arm below. Always GIF."""

from __future__ import annotations

from pathlib import Path

import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from .. import style
from ..gif import MOST_FRAMES, write_gif
from ..recording import Missing, Recording
from .arm import draw_joints
from .overlay import draw_picture, draw_track, read_pictures
from .track_data import time_of_mission

DPI = 120
"""420 pixels wide."""
DRAWN_WITH = (style.ORANGE, style.SKY, style.YELLOW, *style.SEQUENCE)
_BELOW = 0.32
"""Of the height: the joints."""


def write(recording: Recording, path: Path) -> None:
    """Raises Missing, BadData and OSError."""
    pictures = read_pictures(recording)
    if len(pictures) < 2:
        raise Missing("one picture does not move")
    joints = None
    if (recording.folder / "joints.csv").is_file():
        joints = recording.table("joints.csv", "", ["stamp", "position"], ["joint"])
    time = time_of_mission(pictures.track)
    frames = []
    numbers = numpy.linspace(0, len(pictures) - 1, min(len(pictures), MOST_FRAMES)).astype(int)
    for number in numpy.unique(numbers):
        pixels = pictures.read(recording, number)
        share = 1 - _BELOW if joints is not None else 1.0
        height = style.COLUMN * pixels.shape[0] / pixels.shape[1] / share
        figure = Figure(figsize=(style.COLUMN, height), dpi=DPI)
        canvas = FigureCanvasAgg(figure)
        upper = figure.add_axes((0, 1 - share, 1, share))
        draw_picture(upper, pixels)
        draw_track(upper, pictures, number)
        now = pictures.stamps[number]
        label = f"{now - pictures.track.numbers['stamp'][0]:.1f} s  {pictures.track.texts['state'][pictures.rows[number]]}"
        upper.annotate(label, (0, 1), (4, -4), xycoords="axes fraction", textcoords="offset points", va="top",
                       color="white", bbox={"facecolor": style.BLACK, "pad": 1.5})
        if joints is not None:
            lower = figure.add_axes((0.12, 0.09, 0.86, _BELOW - 0.11))
            draw_joints(lower, time, joints)
            lower.axvline(float(time(numpy.array(now))), color=style.BLACK, linewidth=0.8)
            time.limit(lower)
        canvas.draw()
        frames.append(Image.fromarray(numpy.asarray(canvas.buffer_rgba())).convert("RGB"))
    write_gif(frames, DRAWN_WITH, path)
