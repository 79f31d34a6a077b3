# SPDX-License-Identifier: Apache-2.0
"""Which sensor was believed when."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from .. import style
from ..csv_table import Table
from ..decimation import stretches
from ..recording import Recording
from ..time_axis import TimeAxis
from .run_data import Factors, read_factors_if_any, read_sources, read_states, time_of_run

ORDER = ("imu", "gps", "visual_pose", "heading", "weld", "odometer", "relative_pose")
"""From above; others, of estimators to come, after them."""
_LOOKS = (  # states of sources and phases of the estimator, colour
    (("trusted", "running"), style.BLUE),
    (("coasting",), style.SKY),
    (("candidate", "aligning"), style.YELLOW),
    (("doubted", "fault"), style.VERMILLION),
    (("absent", "starting"), style.PALE),
)
_COLOUR_OF = {state: colour for states, colour in _LOOKS for state in states}
_INTERVALS = 150
"""That a panel of a column's width can show."""
_LEAST_SEEN = 1 / 400
"""Of the width: what is shorter is drawn so wide."""


def draw(recording: Recording) -> Figure:
    states = read_states(recording, ["since_absolute_position", "restarts"], ["phase"])
    sources = read_sources(recording, states)
    factors = read_factors_if_any(recording)
    time = time_of_run(recording, states.numbers["stamp"])
    known = {name: place for place, name in enumerate(ORDER)}
    names = sorted(set(sources.texts["source"]), key=lambda name: (known.get(name, len(known)), name))
    since = states.numbers["since_absolute_position"]
    heights = [0.2 * (len(names) + 1), 0.75][:2 if numpy.isfinite(since).any() else 1]
    figure = style.figure(sum(heights) + 1.0)
    panels = numpy.atleast_1d(figure.subplots(len(heights), 1, sharex=True, height_ratios=heights))
    strips = panels[0]
    _draw_strip(strips, time, 0, states.numbers["stamp"], numpy.array(states.texts["phase"], dtype=object))
    for row, name in enumerate(names, 1):
        mine = numpy.array([source == name for source in sources.texts["source"]])
        _draw_strip(strips, time, row, sources.numbers["stamp"][mine],
                    numpy.array(sources.texts["state"], dtype=object)[mine])
        _draw_gated(strips, time, row, name, factors)
    _draw_restarts(strips, time, states)
    strips.set_yticks(range(len(names) + 1), ["estimator", *(name.replace("_", " ") for name in names)])
    strips.set_ylim(len(names) + 0.5, -0.75)
    strips.tick_params(axis="y", length=0)
    strips.spines["left"].set_visible(False)
    if len(panels) == 2:
        edges, longest = longest_since(states.numbers["stamp"], since, time.end)
        panels[1].stairs(longest, time(edges), color=style.BLUE, linewidth=0.8, baseline=None)
        panels[1].set_ylim(0, 1.15 * max(float(numpy.nanmax(longest)), 1e-3))
        panels[1].set_ylabel("longest time\nwithout absolute\nposition [s]")
    time.limit(panels[-1])
    panels[-1].set_xlabel(time.label)
    style.legend_above(figure, *_legend(strips), 3)
    return figure


def longest_since(stamps: numpy.ndarray, since: numpy.ndarray, end: float) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Edges of up to _INTERVALS equal intervals, and the largest value in each; NaN where there is none. Between two
    fixes the time rises and falls back: of its saw teeth only the tips tell something."""
    count = max(1, min(_INTERVALS, len(stamps) // 2))
    edges = numpy.linspace(float(stamps[0]), max(end, float(stamps[-1])), count + 1)
    if edges[-1] <= edges[0]:
        edges = numpy.array([edges[0], edges[0] + 1.0])
    longest = numpy.full(len(edges) - 1, numpy.nan)
    places = numpy.clip(numpy.searchsorted(edges, stamps, side="right") - 1, 0, len(longest) - 1)
    known = numpy.isfinite(since)
    numpy.fmax.at(longest, places[known], since[known])
    return edges, longest


def spans(stamps: numpy.ndarray, states: numpy.ndarray, end: float) -> dict[str, list[tuple[float, float]]]:
    """By state, when it held: each from its stamp to the next, the last to the end."""
    result: dict[str, list[tuple[float, float]]] = {}
    ends = numpy.append(stamps[1:], max(end, float(stamps[-1])))
    begin = 0
    for k in range(len(stamps)):
        if k + 1 == len(stamps) or states[k + 1] != states[k]:
            result.setdefault(str(states[k]), []).append((float(stamps[begin]), float(ends[k])))
            begin = k + 1
    return result


def _draw_strip(axes: Axes, time: TimeAxis, row: int, stamps: numpy.ndarray, states: numpy.ndarray) -> None:
    least = _LEAST_SEEN * float(time(numpy.array(time.end)))
    held = spans(stamps, states, time.end)
    # What matters most comes last, over its neighbours.
    order = ["absent", "starting", "trusted", "running"]
    for state in sorted(held, key=lambda state: order.index(state) if state in order else len(order)):
        starts, ends = (time(numpy.array(edge)) for edge in zip(*held[state]))
        axes.broken_barh([(start, end - start) for start, end in stretches(starts, ends, least)],
                         (row - 0.36, 0.72), color=_COLOUR_OF.get(state, style.GREY), linewidth=0)


def _draw_gated(axes: Axes, time: TimeAxis, row: int, name: str, factors: Factors | None) -> None:
    if factors is None:
        return
    gated = factors.times[(factors.kinds == name) & (factors.outcomes == "gated")]
    if gated.size:
        places = time(gated)
        # Of some that fall on one another, one.
        _, first = numpy.unique(numpy.round(places / float(time(numpy.array(time.end))) / _LEAST_SEEN),
                                return_index=True)
        axes.plot(places[first], numpy.full(first.size, row + 0.22), "|", color=style.BLACK, markersize=4,
                  markeredgewidth=0.5, label="gated measurement")


def _draw_restarts(axes: Axes, time: TimeAxis, states: Table) -> None:
    counts = states.numbers["restarts"]
    moved = states.numbers["stamp"][1:][numpy.diff(counts) > 0]
    if moved.size:
        axes.plot(time(moved), numpy.full(moved.size, -0.55), "v", color=style.PURPLE, markersize=4,
                  markeredgewidth=0, label="restart")


def _legend(axes: Axes) -> tuple[list, list[str]]:
    handles: list = [Patch(color=colour) for _, colour in _LOOKS]
    labels = [", ".join(states) for states, _ in _LOOKS]
    for handle, label in zip(*style.unique_legend(axes)):
        handles.append(handle)
        labels.append(label)
    return handles, labels
