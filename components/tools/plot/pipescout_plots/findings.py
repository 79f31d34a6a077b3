# SPDX-License-Identifier: Apache-2.0
"""Leaks that a thermal camera has found during a mission, for the picture from above of the mission."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy
from matplotlib.axes import Axes

from . import style
from .csv_table import Table, read_table
from .labels import Label
from .recording import Recording


LEAK = "#A3196B"
"""Darker than the purple of other marks: on pipes, which are grey."""


@dataclass
class Findings:
    """Raised when the mission ended, and the true places of a simulation; in the frame of the mission's map."""

    numbers: list[str]
    positions: numpy.ndarray
    """(n, 3)"""
    true_positions: numpy.ndarray

    def labels(self, columns: tuple[int, int]) -> list[Label]:
        """At these two coordinates."""
        return [Label(*place[list(columns)].tolist(), number, LEAK)
                for number, place in zip(self.numbers, self.positions)]

    def marks(self, columns: tuple[int, int]) -> list[tuple[float, float]]:
        return [tuple(place) for place in self.true_positions[:, list(columns)].tolist()]


def read_findings(recording: Recording) -> Findings:
    """Empty without tables of leaks next to those of the recording. Raises BadData."""
    folder = recording.folder.parent / "leaks"
    latest: dict[str, tuple[bool, list[float]]] = {}
    events = _table(recording, folder / "events.csv", ("leak", "state"))
    if events is not None:
        places = numpy.stack([events.numbers[name] for name in "xyz"], axis=-1)
        for leak, state, place in zip(events.texts["leak"], events.texts["state"], places.tolist()):
            latest[leak] = (state == "raised", place)
    raised = {leak: place for leak, (is_raised, place) in latest.items() if is_raised}
    placed = {leak: place for leak, place in raised.items() if numpy.isfinite(place).all()}
    truth = _table(recording, folder / "truth.csv", ())
    true_places = (numpy.empty((0, 3)) if truth is None
                   else numpy.stack([truth.numbers[name] for name in "xyz"], axis=-1))
    if len(placed) < len(raised):
        recording.note("leaks without a known place are not in the picture from above: "
                       + ", ".join(leak for leak in raised if leak not in placed))
    return Findings(list(placed), numpy.array(list(placed.values())).reshape(-1, 3), true_places)


def draw_findings(axes: Axes, findings: Findings, columns: tuple[int, int], what: str) -> None:
    """Without their numbers, which `place_labels` places last. `what` they are called."""
    if len(findings.true_positions):
        axes.plot(*findings.true_positions[:, list(columns)].T, "o", color=style.BLACK, markerfacecolor="none",
                  markersize=6, markeredgewidth=0.6, linestyle="", zorder=9, label=f"true {what}")
    if len(findings.positions):
        axes.plot(*findings.positions[:, list(columns)].T, "X", color=LEAK, markersize=5, markeredgecolor="white",
                  markeredgewidth=0.5, linestyle="", zorder=10, label=f"{what} found")


def _table(recording: Recording, path: Path, texts: tuple[str, ...]) -> Table | None:
    return recording.noted(read_table(path, ["x", "y", "z"], texts)) if path.is_file() else None
