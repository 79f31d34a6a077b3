# SPDX-License-Identifier: Apache-2.0
"""Draws what a result holds: a folder, a list, or the JSON file of `pipescout reproduce`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from . import style
from .contents import Kind, find
from .csv_table import BadData
from .drawing import Drawing
from .recording import Recording
from .reproduction import read_rows
from .subjects import KINDS, REPRODUCTION

PICTURES = (".svg", ".png", ".gif", ".html", ".jpg", ".jpeg")
RECORDINGS = (".mcap", ".db3", ".bag")


def draw(options: argparse.Namespace) -> int:
    """Returns the exit code."""
    result: Path = options.result
    if not result.exists():
        print(f"error: no folder or file '{result}'", file=sys.stderr)
        return 1
    style.begin()
    if result.is_file() and _is_json(result):
        return _draw_reproduction(result, options)
    if result.suffix.lower() in (*PICTURES, *RECORDINGS):
        print(f"error: {_instead(result)}", file=sys.stderr)
        return 1
    return _draw_contents(result, options)


def _draw_contents(result: Path, options: argparse.Namespace) -> int:
    contents = find(result, KINDS)
    held = [each for each in contents.held if options.subject in (None, each.kind.subject)]
    strange = [problem for subjects, problem in contents.strange if options.subject is None or options.subject in subjects]
    if not held:
        for problem in strange:
            print(f"error: {problem}", file=sys.stderr)
        print(f"error: {_nothing(result, options.subject, [each.kind for each in contents.held])}",
              file=sys.stderr)
        return 1
    drawing = Drawing(options.out or (result if result.is_dir() else result.parent) / "pictures", options.format)
    for each in held:
        for picture in each.kind.pictures:
            drawing.draw(picture, each.recording, each.prefix)
    for problem in strange:
        drawing.fail(problem)
    return drawing.finish(contents.notes)


def _draw_reproduction(file: Path, options: argparse.Namespace) -> int:
    """Of the pictures those whose rows the file has."""
    try:
        read_rows(file)
    except BadData as problem:
        print(f"error: {problem}", file=sys.stderr)
        return 1
    drawing = Drawing(options.out or file.parent / "pictures", options.format)
    for subject, picture in REPRODUCTION:
        if subject is None or options.subject in (None, subject):
            drawing.draw(picture, Recording(file.parent, file.parent, file), expected=options.subject is not None)
    return drawing.finish([])


def _is_json(file: Path) -> bool:
    with file.open("rb") as content:
        return content.read(1) in (b"{", b"[")


def _nothing(result: Path, subject: str | None, held: Sequence[Kind]) -> str:
    """Why there is nothing to draw, and what would."""
    if held:
        others = "; ".join(dict.fromkeys(f"{kind.what}: `pipescout plot {kind.subject} {result}`" for kind in held))
        return f"{result} holds nothing of '{subject}', but {others}"
    return f"nothing that can be drawn in {result}: {_instead(result)}"


def _instead(result: Path) -> str:
    """What else to do with a result that has no tables."""
    files = [result] if result.is_file() else [file for file in sorted(result.rglob("*")) if file.is_file()]
    for file in files:
        if file.suffix.lower() in RECORDINGS:
            bag = result if result.is_file() else file.parent
            return f"{file} is a recording; `pipescout summary {bag} --tables DIR` writes the tables of it that are drawn"
    grids = [file for file in files if file.suffix in (".yaml", ".yml") and _is_grid(file)]
    if grids:
        return f"{grids[0]} is a map; `pipescout map show {grids[0]} --out map.png` draws it"
    there = [file for file in files if file.suffix.lower() in PICTURES]
    if there:
        return f"it has no tables, and pictures already: {', '.join(map(str, there[:3]))}" + (
            f" and {len(there) - 3} more" if len(there) > 3 else "")
    reports = [file for file in files if file.name == "report.md"]
    if reports:
        return f"it has no tables; {reports[0]} says what came of it"
    return "there are no tables of a mission, of `estimate`, `rack track`, `track`, `inspect` or `ledger` in it"


def _is_grid(file: Path) -> bool:
    text = file.read_text(encoding="utf-8", errors="replace")
    return "image:" in text and "resolution:" in text
