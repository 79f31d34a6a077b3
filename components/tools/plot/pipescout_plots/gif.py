# SPDX-License-Identifier: Apache-2.0
"""Animations: frames of the same few colours as a GIF that is not large."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import numpy
from matplotlib.colors import to_rgb
from PIL import Image

from . import style

MOST_BYTES = 3_000_000
MOST_FRAMES = 48
FRAME_TIME = 125
"""Milliseconds."""
GREYS = 32


def write_gif(frames: list[Image.Image], drawn_with: Sequence[str], path: Path) -> None:
    """Every other frame is left out until the file is small enough. Raises OSError."""
    content = _gif(frames, drawn_with)
    while len(content) > MOST_BYTES and len(frames) > 2:
        frames = frames[::2]
        content = _gif(frames, drawn_with)
    style.write_bytes(content, path)


def _gif(frames: list[Image.Image], drawn_with: Sequence[str]) -> bytes:
    """All frames have the same few colours: they do not flicker, and what rests costs nothing."""
    palette = Image.new("P", (1, 1))
    palette.putpalette(_colours(drawn_with))
    few = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    buffer = io.BytesIO()
    few[0].save(buffer, format="GIF", save_all=True, append_images=few[1:], duration=FRAME_TIME, loop=0,
                optimize=False)
    return buffer.getvalue()


def _colours(drawn_with: Sequence[str]) -> list[int]:
    greys = [[round(level)] * 3 for level in numpy.linspace(0, 255, GREYS)]
    drawn = [[round(255 * part) for part in to_rgb(colour)] for colour in drawn_with]
    return [part for colour in (*greys, *drawn) for part in colour]
