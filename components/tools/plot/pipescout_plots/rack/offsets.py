# SPDX-License-Identifier: Apache-2.0
"""Where the pipes are, over time (the paper's Figure 8)."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import style
from ..csv_table import BadData, Table
from ..recording import Missing, Recording
from .flight_data import read_true_offsets
from .rack_file import Rack, read_rack
from .timeline import Timeline

_WHY = "the tables of a flight over a rack have it"
MOST_PIPES = 8
"""Colours that there are."""


def draw(recording: Recording) -> Figure:
    table = recording.table("offsets.csv", _WHY, ["stamp", "offset", "standard_deviation", "observed"],
                            ["pipe"])
    table.require_rising("stamp")
    pipes = [pipe for pipe in dict.fromkeys(table.texts["pipe"]) if _moves(table, pipe)]
    if not pipes:
        raise Missing(f"no pipe of {table.path} has an offset other than 0")
    if len(pipes) > MOST_PIPES:
        recording.note(f"offsets shows the first {MOST_PIPES} of {len(pipes)} pipes")
    stamps = table.numbers["stamp"]
    timeline = Timeline(recording, stamps[0], stamps[-1])
    rack = _rack(recording)
    distances = summed_distances(rack)
    truth = read_true_offsets(recording, [pipe.name for pipe in rack.pipes])
    figure = style.figure(3.3)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1, 1.25])
    errors = [_draw_pipe(upper, lower, timeline, table, pipe, style.SEQUENCE[number],
                         distances.get(pipe), truth.get(pipe) if truth else None)
              for number, pipe in enumerate(pipes[:MOST_PIPES])]
    for axes, letter in zip((upper, lower), "ab"):
        timeline.mark(axes, numbers=axes is upper)
        style.label_panel(axes, letter)
        axes.margins(y=0.1)
    upper.set_ylabel("distance d̄ [cm]" if distances else "offset [cm]")
    lower.set_ylabel("error [mm]" if truth else "minus last value [mm]")
    lower.axhline(0, color=style.BLACK, linewidth=0.4)
    lower.set_xlabel(timeline.label)
    _limit(lower, table, pipes, numpy.concatenate(errors))
    figure.align_ylabels()
    handles, labels = style.unique_legend(upper, lower)
    order = sorted(range(len(labels)), key=lambda entry: labels[entry] not in pipes)
    style.legend_above(figure, [handles[k] for k in order], [labels[k] for k in order], 5)
    return figure


def _moves(table: Table, pipe: str) -> bool:
    """Not so the first pipe, which defines the frame, and pipes that cannot be moved."""
    rows = numpy.array(table.texts["pipe"]) == pipe
    return bool((table.numbers["observed"][rows] != 0).any()
                or numpy.nan_to_num(table.numbers["offset"][rows]).any())


def _rack(recording: Recording) -> Rack:
    """Without pipes when it is not known."""
    try:
        return read_rack(recording)
    except (Missing, BadData) as problem:
        recording.note(f"offsets are drawn without the distances of the rack file: {problem}")
        return Rack([])


def summed_distances(rack: Rack) -> dict[str, float]:
    """By pipe, as the rack file has them: d_1 + ... + d_i of equation (24), metres; the gaps between
    neighbouring surfaces of the pipes that run along the first one, added up."""
    row = [pipe for pipe in rack.pipes
           if abs(float(pipe.direction @ rack.pipes[0].direction)) > 0.999]
    row.sort(key=lambda pipe: float(pipe.start[0]))
    result = {}
    total = 0.0
    for before, pipe in zip(row[:-1], row[1:]):
        total += float(pipe.start[0] - pipe.largest_radius - before.start[0] - before.largest_radius)
        result[pipe.name] = total
    return result


def _draw_pipe(upper: Axes, lower: Axes, timeline: Timeline, table: Table, pipe: str, colour: str,
               distance: float | None, truth: float | None) -> numpy.ndarray:
    """`truth`: its true offset, if that is known. Gives what the lower panel shows."""
    rows = numpy.array(table.texts["pipe"]) == pipe
    stamps = table.numbers["stamp"][rows]
    offset = table.numbers["offset"][rows]
    deviation = table.numbers["standard_deviation"][rows]
    observed = numpy.where(table.numbers["observed"][rows] != 0, 0.0, numpy.nan)
    reference = _last(offset) if truth is None else truth
    start = distance or 0.0
    timeline.line(upper, stamps, 100 * (start + offset), color=colour, label=pipe)
    if truth is not None:
        upper.axhline(100 * (start + truth), color=style.BLACK, linewidth=0.6, linestyle=(0, (1.2, 2.2)),
                      zorder=3, label="true")
    error = 1000 * (offset - reference)
    timeline.band(lower, stamps, error - 2000 * deviation, error + 2000 * deviation, color=colour,
                  alpha=0.18)
    timeline.line(lower, stamps, error, color=colour, linewidth=0.4)
    timeline.line(lower, stamps, error + observed, color=colour, linewidth=1.0)
    return error


def _last(offset: numpy.ndarray) -> float:
    finite = offset[numpy.isfinite(offset)]
    return float(finite[-1]) if finite.size else numpy.nan


def _limit(axes: Axes, table: Table, pipes: list[str], errors: numpy.ndarray) -> None:
    """What the pipes come to, not how they begin: six usual standard deviations, and 19 of 20 errors."""
    rows = numpy.isin(table.texts["pipe"], pipes)
    deviation = table.numbers["standard_deviation"][rows]
    deviation = deviation[numpy.isfinite(deviation)]
    if deviation.size and numpy.median(deviation) > 0:
        limit = max(6000 * float(numpy.median(deviation)),
                    1.1 * float(numpy.nanquantile(numpy.abs(errors), 0.95)))
        axes.set_ylim(-limit, limit)
