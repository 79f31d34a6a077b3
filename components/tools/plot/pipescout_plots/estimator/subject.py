# SPDX-License-Identifier: Apache-2.0
"""The subject `estimator`: pictures of what a state estimator said, and why."""

from __future__ import annotations

import argparse
from pathlib import Path

from .. import reproduction
from ..drawing import Drawing
from ..recording import Picture
from ..result import draw_recordings, draw_result
from . import biases, consistency, errors, residuals, sources, trajectory

DATA_FILES = ("estimate.csv", "factors.csv", "sources.csv")
PICTURES = (
    Picture("trajectory", trajectory.draw),
    Picture("errors", errors.draw),
    Picture("consistency", consistency.draw),
    Picture("residuals", residuals.draw),
    Picture("sources", sources.draw),
    Picture("biases", biases.draw),
)
REPRODUCTION = (Picture("figures", reproduction.draw_figures),)


def run(options: argparse.Namespace) -> int:
    return draw_result(options, REPRODUCTION, _draw_mission)


def _draw_mission(mission: Path, drawing: Drawing) -> list[str]:
    return draw_recordings(mission, drawing, "state estimator", DATA_FILES, PICTURES)
