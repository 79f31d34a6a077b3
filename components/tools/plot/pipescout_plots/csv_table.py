# SPDX-License-Identifier: Apache-2.0
"""Reads the CSV files of a mission folder (docs/mission_folder.md, "Data files")."""

from __future__ import annotations

import array
import csv
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy


class BadData(Exception):
    """A file cannot be read; the text names file, line and column."""


@dataclass
class Table:
    """Columns of one file, all of the same length."""

    path: Path
    numbers: dict[str, numpy.ndarray]
    texts: dict[str, list[str]]
    lines: list[int] = field(repr=False)
    notes: list[str] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.lines)

    def require_finite(self, column: str) -> None:
        """Raises BadData when a value is none, or no finite number."""
        self._refuse(column, ~numpy.isfinite(self.numbers[column]), "is not a finite number")

    def require_rising(self, column: str) -> None:
        """Raises BadData unless the column's values are finite and never fall."""
        values = self.numbers[column]
        wrong = ~numpy.isfinite(values)
        wrong[1:] |= numpy.diff(values) < 0
        self._refuse(column, wrong, "is not after the previous line")

    def _refuse(self, column: str, wrong: numpy.ndarray, why: str) -> None:
        if wrong.any():
            row = int(numpy.argmax(wrong))
            raise BadData(f"{self.path}: line {self.lines[row]}: column '{column}': "
                          f"{float(self.numbers[column][row])!r} {why}")


def read_header(path: Path) -> list[str]:
    """The names of the columns."""
    with _open(path) as file:
        return _header(path, _rows(path, file))


def read_table(path: Path, numbers: Sequence[str], texts: Sequence[str] = ()) -> Table:
    """These columns of a file. A last line without its end may have been cut short by a kill: it is
    left out, and the notes say so."""
    with _open(path) as file:
        rows = _rows(path, file)
        header = _header(path, rows)
        missing = [name for name in (*numbers, *texts) if name not in header]
        if missing:
            raise BadData(f"{path}: line 1: no column {_list(missing)}; there are {_list(header)}")
        table = _collect(path, rows, header, numbers, texts)
    return table


def _collect(path: Path, rows: Iterator[tuple[int, list[str]]], header: list[str],
             numbers: Sequence[str], texts: Sequence[str]) -> Table:
    number_columns = [(header.index(name), name, array.array("d")) for name in numbers]
    text_columns: list[tuple[int, list[str]]] = [(header.index(name), []) for name in texts]
    lines: list[int] = []
    notes = []
    cut = _is_cut(path)
    following = next(rows, None)
    while following is not None:
        (line, row), following = following, next(rows, None)
        if following is None and cut:
            notes.append(f"{path}: line {line} has no line end and is left out: it may be cut short")
            break
        if len(row) != len(header):
            raise BadData(f"{path}: line {line}: {len(row)} fields, and {len(header)} columns")
        for index, name, values in number_columns:
            values.append(_number(path, line, name, row[index]))
        for index, column in text_columns:
            column.append(sys.intern(row[index]))
        lines.append(line)
    return Table(path, {name: numpy.array(values, dtype=float) for _, name, values in number_columns},
                 dict(zip(texts, (column for _, column in text_columns))), lines, notes)


def _open(path: Path):
    try:
        return path.open(newline="", encoding="utf-8-sig", errors="replace")
    except OSError as problem:
        raise BadData(f"{path}: {problem.strerror}") from problem


def _rows(path: Path, file) -> Iterator[tuple[int, list[str]]]:
    reader = csv.reader(file)
    line = 1
    try:
        for row in reader:
            if row:
                yield line, row
            line = reader.line_num + 1
    except (csv.Error, OSError) as problem:
        raise BadData(f"{path}: line {line}: {problem}") from problem


def _header(path: Path, rows: Iterator[tuple[int, list[str]]]) -> list[str]:
    first = next(rows, None)
    if first is None:
        raise BadData(f"{path}: empty: the line of column names is missing")
    header = first[1]
    twice = sorted({name for name in header if header.count(name) > 1})
    if twice:
        raise BadData(f"{path}: line 1: duplicate column {_list(twice)}")
    return header


def _number(path: Path, line: int, column: str, text: str) -> float:
    """An empty field is a value that there is not."""
    try:
        return float(text) if text else numpy.nan
    except ValueError:
        raise BadData(f"{path}: line {line}: column '{column}': '{text}' is not a number") from None


def _is_cut(path: Path) -> bool:
    with path.open("rb") as file:
        if file.seek(0, os.SEEK_END) == 0:
            return False
        file.seek(-1, os.SEEK_END)
        return file.read(1) not in (b"\n", b"\r")


def _list(names: Sequence[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)
