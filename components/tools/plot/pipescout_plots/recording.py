# SPDX-License-Identifier: Apache-2.0
"""The recordings of a mission folder, and what a picture of one takes and gives."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from collections.abc import Callable, Sequence

from matplotlib.figure import Figure

from .csv_table import Table, read_header, read_table


class Missing(Exception):
    """There is nothing to draw a picture from; the text says what is missing and why."""


@dataclass
class Recording:
    """One folder of data of a mission."""

    mission: Path
    folder: Path
    alignment: Path | None = None
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
        table = self.noted(read_table(self.path(name, why), numbers, texts))
        if len(table) == 0:
            raise Missing(f"{table.path} has no rows")
        return table

    def noted(self, table: Table) -> Table:
        self.notes += [note for note in table.notes if note not in self.notes]
        return table


@dataclass(frozen=True)
class Picture:
    """`draw` raises Missing and csv_table.BadData."""

    name: str
    draw: Callable[[Recording], Figure]


def mission_recordings(mission: Path, data_files: Sequence[str]) -> list[tuple[str, Recording]]:
    """The folders below a mission folder that hold one of these files, each with what stands before the
    names of its pictures when there are several. They share their notes."""
    folders = sorted({path.parent for name in data_files for path in mission.rglob(name)})
    notes: list[str] = []
    return [(".".join(folder.relative_to(mission).parts) + "." if len(folders) > 1 else "",
             Recording(mission, folder, notes=notes)) for folder in folders]


def image_file(recording: Recording, name: str) -> Path:
    """Of a file that a table names; it may not lead out of the folder."""
    path = (recording.folder / name).resolve()
    if not path.is_relative_to(recording.folder.resolve()):
        raise Missing(f"{name} lies outside of {recording.folder}")
    return path
