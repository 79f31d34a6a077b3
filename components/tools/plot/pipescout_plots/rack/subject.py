# SPDX-License-Identifier: Apache-2.0
"""The subject `rack`: pictures of flights over a pipe rack."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .. import reproduction, style
from ..drawing import Drawing
from ..recording import Picture, Recording, mission_recordings
from . import animation, errors, flight, map, offsets, overlay, table1

DATA_FILES = ("pose.csv", "offsets.csv")
"""Others write a state.csv too."""
PICTURES = (
    Picture("flight", flight.draw),
    Picture("errors", errors.draw),
    Picture("offsets", offsets.draw),
    Picture("overlay", overlay.draw),
    Picture("map", map.draw),
)
REPRODUCTION = (
    Picture("table1", table1.draw),
    Picture("figures", reproduction.draw_figures),
)


def run(options: argparse.Namespace) -> int:
    result: Path = options.result
    style.begin()
    if result.is_dir():
        return _draw_mission(result, options)
    if result.is_file():
        drawing = Drawing(options.out or result.parent / "pictures", options.format)
        for picture in REPRODUCTION:
            drawing.draw(picture, Recording(result, result.parent))
        return drawing.finish([])
    print(f"error: no mission folder or file '{result}'", file=sys.stderr)
    return 1


def _draw_mission(mission: Path, options: argparse.Namespace) -> int:
    drawing = Drawing(options.out or mission / "pictures", options.format)
    recordings = mission_recordings(mission, DATA_FILES)
    if not recordings:
        print(f"no recorded flight over a rack below {mission}", file=sys.stderr)
    for prefix, recording in recordings:
        for picture in PICTURES:
            drawing.draw(picture, recording, prefix)
        drawing.write(f"{prefix}animation", "gif",
                      lambda path, recording=recording: animation.write(recording, path))
    return drawing.finish(list(dict.fromkeys(note for _, recording in recordings for note in recording.notes)))
