# SPDX-License-Identifier: Apache-2.0
"""What a folder or a file holds that can be drawn: told by names and columns of CSV files alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .csv_table import BadData, read_header
from .recording import Animation, Picture, Recording

ANY_NAME = "*"


@dataclass(frozen=True)
class Kind:
    """Data of one kind: tables in a folder, or lists of which each is drawn by itself (ANY_NAME)."""

    subject: str
    what: str
    files: dict[str, frozenset[str]]
    """By name: the columns that tell such a file from those of the same name of other kinds. One of
    the files is enough."""
    pictures: tuple[Picture | Animation, ...]
    """The first is to be looked at first."""


@dataclass
class Held:
    kind: Kind
    recording: Recording
    prefix: str = ""
    """Of the names of its pictures, where others have the same: folder and file."""


@dataclass
class Contents:
    held: list[Held] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    strange: list[tuple[list[str], str]] = field(default_factory=list)
    """Files that have a known name and columns of no kind: the subjects that know the name, and why it
    is not drawn."""


def find(result: Path, kinds: Sequence[Kind]) -> Contents:
    """Of a folder and all below it, or of a CSV file: then of its folder, as far as that file tells."""
    contents = Contents()
    if not result.is_dir():
        mission, files = result.parent, [result]
    else:
        mission, files = result, sorted(result.rglob("*.csv"))
    kinds_of = {file: _kinds_of(file, kinds, contents) for file in files}
    for kind in kinds:
        mine = [file for file, its in kinds_of.items() if kind in its]
        if ANY_NAME in kind.files:
            places = [(file.parent, file) for file in mine]
        else:
            places = [(folder, None) for folder in sorted({file.parent for file in mine})]
        contents.held += [Held(kind, Recording(mission, folder, file, contents.notes)) for folder, file in places]
    names = Counter(picture.name for held in contents.held for picture in held.kind.pictures)
    for held in contents.held:
        if any(names[picture.name] > 1 for picture in held.kind.pictures):
            held.prefix = _prefix(held.recording)
    return contents


def _prefix(recording: Recording) -> str:
    file = recording.file
    parts = [*recording.folder.relative_to(recording.mission).parts, *([file.stem] if file else [])]
    return "".join(f"{part}." for part in parts)


def _kinds_of(file: Path, kinds: Sequence[Kind], contents: Contents) -> list[Kind]:
    by_name = [kind for kind in kinds if file.name in kind.files]
    try:
        header = set(read_header(file))
    except BadData as problem:
        if by_name:
            contents.strange.append(([kind.subject for kind in by_name], str(problem)))
        return []
    found = [kind for kind in kinds
             if any(name in (file.name, ANY_NAME) and columns <= header for name, columns in kind.files.items())]
    if by_name and not found:
        wanted = " or ".join(f"{_list(kind.files[file.name] - header)} ({kind.what})" for kind in by_name)
        contents.strange.append(([kind.subject for kind in by_name],
                                 f"{file}: line 1: no column {wanted}; there are {_list(header)}"))
    return found


def _list(names) -> str:
    return ", ".join(f"'{name}'" for name in sorted(names))
