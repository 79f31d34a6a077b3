# SPDX-License-Identifier: Apache-2.0
"""Hot spots of the pipes that a thermal camera has found during a flight."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy
from matplotlib.axes import Axes

from .. import style
from ..csv_table import Table, read_table
from ..recording import Recording


@dataclass
class Findings:
    """Raised when the flight ended, in the rack frame, and the true places of a simulation."""

    numbers: list[str]
    positions: numpy.ndarray
    true_positions: numpy.ndarray


def read_findings(recording: Recording) -> Findings:
    """Empty without tables of leaks next to those of the flight. Raises BadData."""
    folder = recording.folder.parent / "leaks"
    latest: dict[str, tuple[bool, list[float]]] = {}
    events = _table(recording, folder / "events.csv", ("leak", "state"))
    if events is not None:
        places = numpy.stack([events.numbers[name] for name in "xyz"], axis=-1)
        for leak, state, place in zip(events.texts["leak"], events.texts["state"], places.tolist()):
            latest[leak] = (state == "raised", place)
    raised = {leak: place for leak, (is_raised, place) in latest.items()
              if is_raised and numpy.isfinite(place).all()}
    truth = _table(recording, folder / "truth.csv", ())
    true_places = (numpy.empty((0, 3)) if truth is None
                   else numpy.stack([truth.numbers[name] for name in "xyz"], axis=-1))
    return Findings(list(raised), numpy.array(list(raised.values())).reshape(-1, 3), true_places)


def draw_findings(axes: Axes, findings: Findings) -> None:
    true_places = findings.true_positions
    if len(true_places):
        axes.plot(true_places[:, 1], true_places[:, 0], "o", color=style.BLACK, markerfacecolor="none",
                  markersize=6, markeredgewidth=0.6, zorder=9, label="true hot spot")
    if len(findings.positions):
        axes.plot(findings.positions[:, 1], findings.positions[:, 0], "x", color=style.PURPLE,
                  markersize=4, markeredgewidth=1.0, zorder=10, label="found")
    for number, place in zip(findings.numbers, findings.positions):
        axes.annotate(number, (place[1], place[0]), (4, -7), textcoords="offset points", fontsize=6,
                      color=style.PURPLE, zorder=10)


def _table(recording: Recording, path: Path, texts: tuple[str, ...]) -> Table | None:
    return recording.noted(read_table(path, ["x", "y", "z"], texts)) if path.is_file() else None
