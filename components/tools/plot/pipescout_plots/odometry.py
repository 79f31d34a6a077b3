# SPDX-License-Identifier: Apache-2.0
"""The subject `odometry`: pictures of odometers, welds and places in the pipe."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from . import (eddy_current, ledger_alignment, position_error, readings, reproduction, style,
               support_graph)
from .drawing import Drawing
from .recording import Picture, Recording, find_recordings

DATA_FILES = ("fused.csv", "positions.csv", "welds.csv", "eddy_current.csv", "readings.csv")

OF_A_CRAWLER = (
    Picture("support_graph", support_graph.draw),
    Picture("position_error", position_error.draw),
    Picture("eddy_current", eddy_current.draw),
)
OF_SINGLE_READINGS = (Picture("readings", readings.draw),)
ALIGNMENT = Picture("ledger_alignment", ledger_alignment.draw)
REPRODUCTION = (
    Picture("detector_curve", reproduction.draw_curve),
    Picture("rules_in_bends", reproduction.draw_rules),
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
    folders = find_recordings(mission, DATA_FILES)
    if not folders:
        print(f"no recorded data below {mission}", file=sys.stderr)
    notes: list[str] = []
    for folder in folders:
        recording = Recording(mission, folder, notes=notes)
        prefix = ".".join(folder.relative_to(mission).parts) + "." if len(folders) > 1 else ""
        single = (folder / "readings.csv").is_file()
        for picture in OF_SINGLE_READINGS if single else OF_A_CRAWLER:
            drawing.draw(picture, recording, prefix)
    alignment = options.alignment or mission / "alignment.csv"
    if options.alignment or alignment.is_file():
        drawing.draw(ALIGNMENT, Recording(mission, mission, alignment, notes))
    return drawing.finish(notes)
