# SPDX-License-Identifier: Apache-2.0
"""What every subject does with a result: a mission's folder, or the JSON file of `pipescout reproduce`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from . import style
from .drawing import Drawing
from .recording import Picture, Recording, mission_recordings


def draw_result(options: argparse.Namespace, figures: Sequence[Picture],
                draw_mission: Callable[[Path, Drawing], list[str]]) -> int:
    """Draws `figures` of a file; `draw_mission` draws a folder and returns notes. Returns the exit code."""
    result: Path = options.result
    style.begin()
    if result.is_dir():
        drawing = Drawing(options.out or result / "pictures", options.format)
        return drawing.finish(list(dict.fromkeys(draw_mission(result, drawing))))
    if result.is_file():
        drawing = Drawing(options.out or result.parent / "pictures", options.format)
        for picture in figures:
            drawing.draw(picture, Recording(result, result.parent))
        return drawing.finish([])
    print(f"error: no mission folder or file '{result}'", file=sys.stderr)
    return 1


def draw_recordings(mission: Path, drawing: Drawing, what: str, data_files: Sequence[str],
                    pictures: Sequence[Picture],
                    animation: tuple[str, Callable[[Recording, Path], None]] | None = None) -> list[str]:
    """Each recording that holds one of the files; `what` is said to be missing when there is none."""
    recordings = mission_recordings(mission, data_files)
    if not recordings:
        print(f"no recorded {what} below {mission}", file=sys.stderr)
    for prefix, recording in recordings:
        for picture in pictures:
            drawing.draw(picture, recording, prefix)
        if animation is not None:
            name, write = animation
            drawing.write(prefix + name, "gif", lambda path, mine=recording: write(mine, path))
    return recordings[0][1].notes if recordings else []
