# SPDX-License-Identifier: Apache-2.0
"""The subject `rack`: pictures of flights over a pipe rack."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import reproduction
from ..drawing import Drawing
from ..recording import Picture
from ..result import draw_recordings, draw_result
from . import animation, errors, flight, map, offsets, overlay, table1

DATA_FILES = ("pose.csv", "offsets.csv")
"""Others write a state.csv too."""
PICTURES = (
    Picture("flight", flight.draw),
    Picture("errors", errors.draw),
    Picture("offsets", offsets.draw),
    Picture("overlay", overlay.draw),
    Picture("map", map.draw),
)
REPRODUCTION = (
    Picture("table1", table1.draw),
    Picture("figures", reproduction.draw_figures),
)


def run(options: argparse.Namespace) -> int:
    return draw_result(options, REPRODUCTION, _draw_mission)


def _draw_mission(mission: Path, drawing: Drawing) -> list[str]:
    return draw_recordings(mission, drawing, "flight over a rack", DATA_FILES, PICTURES,
                           ("animation", animation.write))
