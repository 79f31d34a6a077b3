# SPDX-License-Identifier: Apache-2.0
"""Draws pictures one after the other, says what was drawn and what not, and counts."""

from __future__ import annotations

import sys
from pathlib import Path

from . import style
from .csv_table import BadData
from .recording import Animation, Missing, Picture, Recording


class Drawing:
    def __init__(self, folder: Path, suffix: str) -> None:
        self._folder = folder
        self._suffix = suffix
        self._drawn = 0
        self._failed = 0

    def draw(self, picture: Picture | Animation, recording: Recording, prefix: str = "",
             expected: bool = True) -> None:
        """Prints path and what it shows, with a tab between them; of what is expected also why it is missing."""
        name = prefix + picture.name
        try:
            if isinstance(picture, Animation):
                path = self._folder / f"{name}.gif"
                picture.write(recording, path)
            else:
                path = self._folder / f"{name}.{self._suffix}"
                style.write(picture.draw(recording), path)
            self._drawn += 1
            print(path, picture.shows, sep="\t", flush=True)
        except Missing as reason:
            if expected:
                print(f"not drawn: {name}: {reason}", file=sys.stderr)
        except (BadData, OSError) as problem:
            self.fail(f"{name}: {problem}")

    def fail(self, problem: str) -> None:
        self._failed += 1
        print(f"error: {problem}", file=sys.stderr)

    def finish(self, notes: list[str]) -> int:
        """Prints the notes. The exit code: 0 when something was drawn and nothing went wrong."""
        for note in notes:
            print(f"note: {note}", file=sys.stderr)
        if self._drawn == 0 and self._failed == 0:
            print("error: nothing could be drawn", file=sys.stderr)
        return 0 if self._drawn and not self._failed else 1
