# SPDX-License-Identifier: Apache-2.0
"""A recording, and what a picture of one takes and gives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from matplotlib.figure import Figure

from .csv_table import Table, read_header, read_table


class Missing(Exception):
    """There is nothing to draw a picture from; the text says what is missing and why."""


@dataclass
class Recording:
    """One folder of data of a mission, or one list."""

    mission: Path
    folder: Path
    file: Path | None = None
    """The list, of any name, or the JSON file."""
    notes: list[str] = field(default_factory=list)

    def path(self, name: str, why: str) -> Path:
        path = self.folder / name
        if not path.is_file():
            raise Missing(f"no {name} in {self.folder}: {why}")
        return path

    def header(self, name: str, why: str) -> list[str]:
        return read_header(self.path(name, why))

    def table(self, name: str, why: str, numbers: Sequence[str], texts: Sequence[str] = ()) -> Table:
        """Raises Missing when the file is not there or has no rows, with `why` it could be so."""
        return self._with_rows(read_table(self.path(name, why), numbers, texts))

    def list(self, numbers: Sequence[str], texts: Sequence[str] = ()) -> Table:
        """Of the list that the recording is. Raises Missing when it has no rows."""
        return self._with_rows(read_table(self.file, numbers, texts))

    def noted(self, table: Table) -> Table:
        self.note(*table.notes)
        return table

    def note(self, *notes: str) -> None:
        """To be said once, however many pictures come across it."""
        self.notes += [note for note in notes if note not in self.notes]

    def _with_rows(self, table: Table) -> Table:
        if len(self.noted(table)) == 0:
            raise Missing(f"{table.path} has no rows")
        return table


@dataclass(frozen=True)
class Picture:
    """`draw` raises Missing and csv_table.BadData."""

    name: str
    shows: str
    """To someone who has not seen one before: printed beside its path."""
    draw: Callable[[Recording], Figure]


@dataclass(frozen=True)
class Animation:
    """Always GIF. `write` raises Missing, csv_table.BadData and OSError."""

    name: str
    shows: str
    write: Callable[[Recording, Path], None]


def image_file(recording: Recording, name: str) -> Path:
    """Of a file that a table names; it may not lead out of the folder."""
    path = (recording.folder / name).resolve()
    if not path.is_relative_to(recording.folder.resolve()):
        raise Missing(f"{name} lies outside of {recording.folder}")
    return path
