# SPDX-License-Identifier: Apache-2.0
"""The subject `odometry`: pictures of odometers, welds and places in the pipe."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from . import eddy_current, ledger_alignment, position_error, readings, reproduction, support_graph
from .drawing import Drawing
from .recording import Picture, Recording, mission_recordings
from .result import draw_result

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
    return draw_result(options, REPRODUCTION,
                       lambda mission, drawing: _draw_mission(mission, drawing, options.alignment))


def _draw_mission(mission: Path, drawing: Drawing, named_alignment: Path | None) -> list[str]:
    recordings = mission_recordings(mission, DATA_FILES)
    if not recordings:
        print(f"no recorded data below {mission}", file=sys.stderr)
    for prefix, recording in recordings:
        single = (recording.folder / "readings.csv").is_file()
        for picture in OF_SINGLE_READINGS if single else OF_A_CRAWLER:
            drawing.draw(picture, recording, prefix)
    notes = recordings[0][1].notes if recordings else []
    alignment = named_alignment or mission / "alignment.csv"
    if named_alignment or alignment.is_file():
        drawing.draw(ALIGNMENT, Recording(mission, mission, alignment, notes))
    return notes
