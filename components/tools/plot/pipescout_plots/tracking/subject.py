# SPDX-License-Identifier: Apache-2.0
"""The subject `tracking`: the track of a pipe, and the arm that keeps it in view."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import reproduction
from ..drawing import Drawing
from ..recording import Picture
from ..result import draw_recordings, draw_result
from . import animation, arm, errors, overlay

DATA_FILES = ("track.csv",)
PICTURES = (
    Picture("tracking_errors", errors.draw),
    Picture("particles", overlay.draw),
    Picture("arm", arm.draw),
)
REPRODUCTION = (Picture("figures", reproduction.draw_figures),)


def run(options: argparse.Namespace) -> int:
    return draw_result(options, REPRODUCTION, _draw_mission)


def _draw_mission(mission: Path, drawing: Drawing) -> list[str]:
    return draw_recordings(mission, drawing, "track", DATA_FILES, PICTURES, ("tracking", animation.write))
