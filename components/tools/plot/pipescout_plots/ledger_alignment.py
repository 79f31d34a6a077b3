# SPDX-License-Identifier: Apache-2.0
"""How the odometer of one run departs from the weld ledger."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import style
from .csv_table import Table
from .decimation import decimate, envelope
from .recording import Missing, Recording

CERTAIN = 0.99
"""Matches below this probability are marked."""
SPREAD = 11
"""Joints that the median of the stretch is taken over."""


def draw(recording: Recording) -> Figure:
    table = recording.list(["run_chainage", "ledger_chainage", "difference", "standard_deviation", "probability"])
    matched = (numpy.isfinite(table.numbers["run_chainage"]) &
               numpy.isfinite(table.numbers["difference"]) &
               numpy.isfinite(table.numbers["ledger_chainage"]))
    if not matched.any():
        raise Missing(f"{table.path} has no matched weld")
    return _picture(table, matched)


def stretch(chainage: numpy.ndarray, difference: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
    """By joint, at its middle: the change of the difference, in per cent of the joint's length. Welds
    at the same chainage make no joint."""
    lengths = numpy.diff(chainage)
    joints = lengths > 0
    middles = (chainage[1:] + chainage[:-1])[joints] / 2
    return middles, 100 * numpy.diff(difference)[joints] / lengths[joints]


def running_median(values: numpy.ndarray, spread: int) -> numpy.ndarray:
    """Over `spread` values about each, fewer at the ends."""
    half = spread // 2
    return numpy.array([numpy.median(values[max(0, k - half):k + half + 1])
                        for k in range(len(values))])


def _picture(table: Table, matched: numpy.ndarray) -> Figure:
    order = numpy.flatnonzero(matched)
    order = order[numpy.argsort(table.numbers["ledger_chainage"][order], kind="stable")]
    columns = {name: values[order] for name, values in table.numbers.items()}
    unit, name = (1000.0, "km") if numpy.ptp(columns["ledger_chainage"]) > 5000 else (1.0, "m")
    figure = style.figure(3.7)
    upper, middle, lower = figure.subplots(3, 1, sharex=True, height_ratios=[1.0, 1.2, 1.0])
    _draw_difference(upper, columns, unit)
    _draw_unmatched(upper, table, unit)
    _draw_remainder(middle, columns, unit)
    _draw_stretch(lower, columns, unit)
    lower.set_xlabel(f"chainage by the ledger [{name}]")
    figure.align_ylabels()
    for axes, letter in zip((upper, middle, lower), "abc"):
        style.label_panel(axes, letter)
    entries = [pair for axes in (upper, middle, lower)
               for pair in zip(*axes.get_legend_handles_labels())]
    style.legend_above(figure, [handle for handle, _ in entries], [label for _, label in entries], 3)
    return figure


def straight_line(chainage: numpy.ndarray, difference: numpy.ndarray) -> tuple[float, float]:
    """Least-squares slope and value at chainage 0; no slope from welds at one place."""
    if numpy.ptp(chainage) == 0:
        return 0.0, float(difference.mean())
    slope, offset = numpy.polyfit(chainage, difference, 1)
    return float(slope), float(offset)


def _draw_difference(axes: Axes, columns: dict[str, numpy.ndarray], unit: float) -> None:
    chainage, difference = columns["ledger_chainage"], columns["difference"]
    axes.plot(*decimate(chainage / unit, difference, style.GROUPS), color=style.BLUE,
              label="matched weld")
    unsure = columns["probability"] < CERTAIN
    if unsure.any():
        axes.plot(chainage[unsure] / unit, difference[unsure], "D", color=style.ORANGE, markersize=2.5,
                  label=f"probability < {CERTAIN}")
    axes.margins(y=0.18)
    axes.set_ylabel("difference [m]")


def _draw_remainder(axes: Axes, columns: dict[str, numpy.ndarray], unit: float) -> None:
    """What a straight line leaves, where the standard deviation can be seen beside it."""
    chainage = columns["ledger_chainage"]
    slope, offset = straight_line(chainage, columns["difference"])
    rest = columns["difference"] - (offset + slope * chainage)
    band = 2 * columns["standard_deviation"]
    x, low, high = envelope(chainage / unit, rest - band, rest + band, style.GROUPS)
    axes.fill_between(x, low, high, color=style.PALE_BLUE, linewidth=0, label="±2σ")
    axes.plot(*decimate(chainage / unit, rest, style.GROUPS), color=style.BLUE, linewidth=0.6)
    axes.set_ylabel("rest [m]")
    line = f"{offset:.2f} m {'-' if slope < 0 else '+'} {100 * abs(slope):.3f} % of the chainage"
    axes.set_title("difference minus " + line.replace("-", "\N{MINUS SIGN}"), loc="right", fontsize=6, pad=2)


def _draw_unmatched(axes: Axes, table: Table, unit: float) -> None:
    """Ticks at the edges: above what only the run has, below what only the ledger has."""
    run, ledger = table.numbers["run_chainage"], table.numbers["ledger_chainage"]
    new = numpy.isfinite(run) & ~numpy.isfinite(ledger)
    missing = ~numpy.isfinite(run) & numpy.isfinite(ledger)
    matched = numpy.isfinite(run) & numpy.isfinite(ledger)
    order = numpy.argsort(run[matched], kind="stable")
    by_ledger = numpy.interp(run[new], run[matched][order], ledger[matched][order])
    for places, height, marker, colour, label in (
            (by_ledger, 0.97, "v", style.VERMILLION, "only in the run"),
            (ledger[missing], 0.03, "^", style.BLACK, "only in the ledger")):
        if places.size:
            axes.plot(places / unit, numpy.full(places.size, height), marker, color=colour, markersize=3.5,
                      transform=axes.get_xaxis_transform(), label=label)


def _draw_stretch(axes: Axes, columns: dict[str, numpy.ndarray], unit: float) -> None:
    middles, percent = stretch(columns["ledger_chainage"], columns["difference"])
    axes.axhline(0, color=style.BLACK, linewidth=0.4)
    axes.plot(*decimate(middles / unit, percent, style.GROUPS), ".", color=style.GREY, markersize=2,
              markeredgewidth=0, label="joint")
    axes.plot(*decimate(middles / unit, running_median(percent, SPREAD), style.GROUPS),
              color=style.VERMILLION, label=f"median of {SPREAD} joints")
    axes.set_ylabel("stretch [%]")
