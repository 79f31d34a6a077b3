# SPDX-License-Identifier: Apache-2.0
"""The subject `navigation`: map, plans and driven way, and what the navigator did when."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .. import reproduction, style
from ..drawing import Drawing
from ..recording import Picture, Recording, mission_recordings
from . import plant, timeline

DATA_FILES = ("plan.csv",)
PICTURES = (
    Picture("plant", plant.draw),
    Picture("navigation", timeline.draw),
)
FIGURES = Picture("figures", reproduction.draw_figures)


def run(options: argparse.Namespace) -> int:
    result: Path = options.result
    style.begin()
    if result.is_dir():
        return _draw_mission(result, options)
    if result.is_file():
        drawing = Drawing(options.out or result.parent / "pictures", options.format)
        drawing.draw(FIGURES, Recording(result, result.parent))
        return drawing.finish([])
    print(f"error: no mission folder or file '{result}'", file=sys.stderr)
    return 1


def _draw_mission(mission: Path, options: argparse.Namespace) -> int:
    drawing = Drawing(options.out or mission / "pictures", options.format)
    recordings = mission_recordings(mission, DATA_FILES)
    if not recordings:
        print(f"no recorded plan below {mission}", file=sys.stderr)
    for prefix, recording in recordings:
        for picture in PICTURES:
            drawing.draw(picture, recording, prefix)
    return drawing.finish(list(dict.fromkeys(note for _, recording in recordings for note in recording.notes)))
