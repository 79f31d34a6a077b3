# SPDX-License-Identifier: Apache-2.0
"""The subject `navigation`: map, plans and driven way, and what the navigator did when."""

from __future__ import annotations

from ..contents import Kind
from ..recording import Picture
from . import plant, timeline

KINDS = (
    Kind("navigation", "a robot that is navigated", {"plan.csv": frozenset()}, (
        Picture("plant", "the plant from above: its map, planned and driven way, obstacles, pipes seen, leaks with "
                "their numbers", plant.draw),
        Picture("navigation", "speed, deviation from the path, and why it was slow or stood, over time",
                timeline.draw),
    )),
)
