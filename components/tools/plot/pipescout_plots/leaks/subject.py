# SPDX-License-Identifier: Apache-2.0
"""The subject `leaks`: what `pipescout inspect leaks` and the reports of missions found."""

from __future__ import annotations

from ..contents import Kind
from ..recording import Picture
from . import leaks, timeline

KINDS = (
    Kind("leaks", "leaks that were found", {"leaks.csv": frozenset({"mean_delta_k"})}, (
        Picture("leaks", "each leak found: where it is, how far its temperature is from the pipe's, how severe", leaks.draw),
    )),
    Kind("leaks", "thermal images and the leaks in them", {"detections.csv": frozenset({"largest_delta"}),
                                                           "events.csv": frozenset({"peak_delta"})}, (
        Picture("leak_timeline", "what was seen in each thermal image over time, and when each leak was raised",
                timeline.draw),
    )),
)
