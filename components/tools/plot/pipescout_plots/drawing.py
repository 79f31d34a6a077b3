# SPDX-License-Identifier: Apache-2.0
"""Draws pictures one after the other, says what was drawn and what not, and counts."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from . import style
from .csv_table import BadData
from .recording import Missing, Picture, Recording


class Drawing:
    def __init__(self, folder: Path, suffix: str) -> None:
        self._folder = folder
        self._suffix = suffix
        self._drawn = 0
        self._failed = 0

    def draw(self, picture: Picture, recording: Recording, prefix: str = "") -> None:
        self.write(prefix + picture.name, self._suffix,
                   lambda path: style.write(picture.draw(recording), path))

    def write(self, name: str, suffix: str, write: Callable[[Path], None]) -> None:
        """`write` puts the picture at the path; it raises what a picture's `draw` raises, and OSError."""
        try:
            path = self._folder / f"{name}.{suffix}"
            write(path)
            self._drawn += 1
            print(path, flush=True)
        except Missing as reason:
            print(f"not drawn: {name}: {reason}", file=sys.stderr)
        except (BadData, OSError) as problem:
            self._failed += 1
            print(f"error: {name}: {problem}", file=sys.stderr)

    def finish(self, notes: list[str]) -> int:
        """Prints the notes. The exit code: 0 when something was drawn and nothing went wrong."""
        for note in notes:
            print(f"note: {note}", file=sys.stderr)
        if self._drawn == 0:
            print("error: nothing could be drawn", file=sys.stderr)
        return 0 if self._drawn and not self._failed else 1
