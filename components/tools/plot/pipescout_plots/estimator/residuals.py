# SPDX-License-Identifier: Apache-2.0
"""How well each measurement fitted, and what became of it: a panel per kind of factor."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import style
from ..decimation import decimate
from ..recording import Recording
from ..time_axis import TimeAxis
from .run_data import Factors, read_factors, time_of_run

KINDS = ("imu", "gps", "visual_pose", "heading", "weld", "centre_line", "odometer", "relative_pose",
         "non_holonomic", "zero_velocity", "zero_angular_rate", "prior")
"""In this order; others, of estimators to come, after them."""
_LEAST = 1e-3
"""What fits better is drawn here."""
_FEW = 60
"""Measurements of a class that get larger marks."""
_GROUPS = 120
"""Runs of measurements that a class of a kind is thinned to."""
_LOOKS = (  # colour, marker, size, which
    ("weight above 0.9", style.BLUE, ".", 2.2),
    ("weight 0.5 to 0.9", style.SKY, ".", 2.2),
    ("weight below 0.5", style.ORANGE, ".", 2.8),
    ("gated", style.VERMILLION, "x", 3.0),
    ("quarantined", style.PURPLE, "s", 2.4),
    ("waiting, late, refused", style.GREY, "+", 3.0),
)


def draw(recording: Recording) -> Figure:
    factors = read_factors(recording)
    time = time_of_run(recording, factors.times)
    known = {kind: place for place, kind in enumerate(KINDS)}
    kinds = sorted(set(factors.kinds.tolist()), key=lambda kind: (known.get(kind, len(known)), kind))
    figure = style.figure(0.62 * len(kinds) + 0.9)
    panels = numpy.atleast_1d(figure.subplots(len(kinds), 1, sharex=True))
    for axes, kind in zip(panels, kinds):
        _draw(axes, time, factors, factors.kinds == kind)
        axes.set_title(_title(kind, factors.outcomes[factors.kinds == kind]), loc="left", pad=2)
    time.limit(panels[-1])
    panels[-1].set_xlabel(time.label)
    figure.supylabel("χ² per degree of freedom [–]", fontsize=7)
    style.legend_above(figure, *_legend(panels), 3)
    return figure


def classes(factors: Factors) -> numpy.ndarray:
    """The number of the look of each factor."""
    result = numpy.full(len(factors.times), 5)
    accepted = factors.outcomes == "accepted"
    result[accepted] = numpy.select([factors.weights[accepted] > 0.9, factors.weights[accepted] >= 0.5],
                                    [0, 1], 2)
    result[factors.outcomes == "gated"] = 3
    result[factors.outcomes == "quarantined"] = 4
    return result


def _draw(axes: Axes, time: TimeAxis, factors: Factors, of_kind: numpy.ndarray) -> None:
    look_of = classes(factors)
    # Without a residual it has no place on the axis but its foot.
    values = numpy.maximum(numpy.nan_to_num(factors.chi_squares, nan=_LEAST), _LEAST)
    axes.axhline(1, color=style.BLACK, linewidth=0.4, linestyle=(0, (3, 2)), zorder=1)
    for number, (label, colour, marker, size) in enumerate(_LOOKS):
        rows = numpy.flatnonzero(of_kind & (look_of == number) & numpy.isfinite(values))
        if rows.size:
            rows = rows[numpy.argsort(factors.times[rows], kind="stable")]
            kept = decimate(numpy.arange(rows.size), values[rows], _GROUPS)[0]
            rows = rows[kept]
            axes.plot(time(factors.times[rows]), values[rows], marker, color=colour,
                      markersize=size + (1.5 if rows.size < _FEW and marker == "." else 0),
                      markeredgewidth=0 if marker in ".s" else 0.6, linestyle="", zorder=2 + number,
                      label=label)
    axes.set_yscale("log")
    shown = values[of_kind & numpy.isfinite(values)]
    bottom, top = (float(shown.min()), float(shown.max())) if shown.size else (1.0, 1.0)
    axes.set_ylim(min(bottom, 0.1) / 2, 3 * max(top, 10))
    axes.set_yticks(_ticks(*axes.get_ylim()))
    axes.minorticks_off()


def _ticks(bottom: float, top: float) -> list[float]:
    """Two or three decades that are labelled, 1 among them."""
    decades = range(int(numpy.ceil(numpy.log10(bottom))), int(numpy.floor(numpy.log10(top))) + 1)
    step = max(1, -(-len(decades) // 3))
    return [10.0 ** decade for decade in decades if decade % step == 0]


def _title(kind: str, outcomes: numpy.ndarray) -> str:
    counts = {outcome: int((outcomes == outcome).sum()) for outcome in sorted(set(outcomes.tolist()))}
    accepted = counts.pop("accepted", 0)
    return ", ".join([f"{kind.replace('_', ' ')}: {accepted} accepted",
                      *(f"{count} {outcome.replace('_', ' ')}" for outcome, count in counts.items())])


def _legend(panels: numpy.ndarray) -> tuple[list, list[str]]:
    """In the order of the looks, whichever panel they are in."""
    entries = dict(zip(*style.unique_legend(*panels)[::-1]))
    labels = [look[0] for look in _LOOKS if look[0] in entries]
    return [entries[label] for label in labels], labels
