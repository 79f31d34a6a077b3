# SPDX-License-Identifier: Apache-2.0
"""The subject `navigation`: map, plans and driven way, and what the navigator did when."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import reproduction
from ..drawing import Drawing
from ..recording import Picture
from ..result import draw_recordings, draw_result
from . import plant, timeline

DATA_FILES = ("plan.csv",)
PICTURES = (
    Picture("plant", plant.draw),
    Picture("navigation", timeline.draw),
)
REPRODUCTION = (Picture("figures", reproduction.draw_figures),)


def run(options: argparse.Namespace) -> int:
    return draw_result(options, REPRODUCTION, _draw_mission)


def _draw_mission(mission: Path, drawing: Drawing) -> list[str]:
    return draw_recordings(mission, drawing, "plan", DATA_FILES, PICTURES)
