# SPDX-License-Identifier: Apache-2.0
"""How far the place in the pipe was from the truth, beside what it says of itself."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from . import style
from .csv_table import Table
from .decimation import decimate, envelope, one_way_pieces
from .recording import Missing, Recording

_COLUMNS = ["stamp", "odometer_distance", "joint", "distance_into_joint", "chainage"]
_READABLE = 5
"""Times that the usual error fits into the axis: of more it would be less than a tenth of the panel, a line."""
_NO_TRUTH = "ground truth is available in simulated runs only"


def draw(recording: Recording) -> Figure:
    positions = recording.table(
        "positions.csv", "the tables of a crawler have it",
        [*_COLUMNS, "known", "locked", "standard_deviation", "double_slip_detected",
         "tally_error_detected"])
    truth = recording.table("truth.csv", _NO_TRUTH, _COLUMNS, ["orientation"])
    positions.require_rising("stamp")
    truth.require_rising("stamp")
    travelled = _interpolated(positions.numbers["stamp"], truth, "odometer_distance")
    error = position_error(positions, truth)
    if not numpy.isfinite(error).any():
        raise Missing(f"{positions.path} has no position within the time of {truth.path}")
    return _picture(recording, positions, truth, travelled, error)


def position_error(positions: Table, truth: Table) -> numpy.ndarray:
    """Estimate minus truth, in metres; NaN where there is no estimate or no truth.

    In the true joint, or the one beside it, the difference of the distances from the weld at which the
    joint begins: neither the tally nor the boundary between two joints plays a part in it. Elsewhere
    the difference of the chainages.
    """
    stamps = positions.numbers["stamp"]
    joint = positions.numbers["joint"]
    travelled = _interpolated(stamps, truth, "odometer_distance")
    true_joint = truth.numbers["joint"][_nearest(truth.numbers["stamp"], stamps)]
    into_joint = numpy.full(len(stamps), numpy.nan)
    for number, (start, sign) in _joint_starts(truth).items():
        here = joint == number
        into_joint[here] = sign * (travelled[here] - start)
    by_joint = positions.numbers["distance_into_joint"] - into_joint
    by_chainage = positions.numbers["chainage"] - _interpolated(stamps, truth, "chainage")
    near = (numpy.abs(joint - true_joint) <= 1) & numpy.isfinite(by_joint)
    error = numpy.where(near, by_joint, by_chainage)
    error[positions.numbers["known"] == 0] = numpy.nan
    return error


def _joint_starts(truth: Table) -> dict[int, tuple[float, float]]:
    """By joint: the distance travelled at its first weld, and the direction through it."""
    joints = truth.numbers["joint"]
    sign = numpy.where(numpy.array(truth.texts["orientation"]) == "backward", -1.0, 1.0)
    starts = truth.numbers["odometer_distance"] - sign * truth.numbers["distance_into_joint"]
    result = {}
    for joint in numpy.unique(joints[numpy.isfinite(joints)]):
        rows = joints == joint
        result[int(joint)] = (float(numpy.nanmedian(starts[rows])), float(sign[rows][0]))
    return result


def _interpolated(stamps: numpy.ndarray, table: Table, column: str) -> numpy.ndarray:
    """NaN outside of the table's time."""
    return numpy.interp(stamps, table.numbers["stamp"], table.numbers[column], left=numpy.nan,
                        right=numpy.nan)


def _nearest(stamps: numpy.ndarray, wanted: numpy.ndarray) -> numpy.ndarray:
    after = numpy.clip(numpy.searchsorted(stamps, wanted), 1, max(len(stamps) - 1, 1))
    before = after - 1
    after = numpy.minimum(after, len(stamps) - 1)
    return numpy.where(wanted - stamps[before] <= stamps[after] - wanted, before, after)


def _picture(recording: Recording, positions: Table, truth: Table, travelled: numpy.ndarray,
             error: numpy.ndarray) -> Figure:
    numbers = positions.numbers
    locked = numbers["locked"] != 0
    figure = style.figure(2.5)
    axes = figure.subplots()
    band = 2 * numpy.where(locked, numbers["standard_deviation"], numpy.nan)
    certain = numpy.where(locked, error, numpy.nan)
    shown = certain if locked.any() else error
    limit = style.symmetric_limit(numpy.concatenate((shown, band)), 1.3)
    x, low, high = envelope(travelled, -band, band, style.GROUPS)
    # A band that runs back over itself would have holes.
    for part, piece in enumerate(one_way_pieces(x)):
        axes.fill_between(x[piece], low[piece], high[piece], color=style.PALE_BLUE, linewidth=0,
                          label=None if part else "±2σ")
    _line(axes, travelled, numpy.where(locked, numpy.nan, error), limit, style.GREY, "not certain")
    _line(axes, travelled, certain, limit, style.BLUE, "error")
    axes.axhline(0, color=style.BLACK, linewidth=0.4)
    _draw_welds(axes, recording, truth)
    _draw_events(axes, numbers, travelled, locked)
    linear = linear_part(numpy.concatenate((shown, band)), limit)
    if linear is not None:
        axes.set_yscale("symlog", linthresh=linear)
        ticks = _ticks(linear, limit)
        axes.set_yticks([-tick for tick in ticks] + [0] + ticks)
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}".replace("-", "\N{MINUS SIGN}")))
        axes.set_title(f"logarithmic beyond ±{linear:g} m", loc="right", fontsize=6, pad=2, color=style.GREY)
        axes.minorticks_off()
    axes.set_ylim(-limit, limit)
    axes.set_xlim(numpy.nanmin(travelled), numpy.nanmax(travelled))
    axes.set_xlabel("distance travelled [m]")
    axes.set_ylabel("position error [m]")
    entries = {label: handle for handle, label in zip(*axes.get_legend_handles_labels())}
    style.legend_above(figure, list(entries.values()), list(entries), 4)
    return figure


def linear_part(values: numpy.ndarray, limit: float) -> float | None:
    """Half the height of the part of the axis that is linear, a power of ten in metres that most of the errors and
    deviations keep to; none when an axis that is linear as a whole shows them."""
    usual = numpy.abs(values[numpy.isfinite(values)])
    if not usual.size:
        return None
    linear = float(10.0 ** numpy.ceil(numpy.log10(max(float(numpy.median(usual)), 1e-3))))
    return linear if linear * _READABLE < limit else None


def _ticks(linear: float, limit: float) -> list[float]:
    """Above 0: half of the linear part and its end, then 2, 5 and 10 times as much, or whole decades of many."""
    steps = (2, 5, 10) if limit < 10 * linear else (10,)
    ticks = [linear / 2, linear]
    decade = linear
    while decade < limit:
        ticks += [step * decade for step in steps if step * decade <= limit]
        decade *= 10
    return ticks


def _line(axes: Axes, x: numpy.ndarray, y: numpy.ndarray, limit: float, colour: str,
          label: str) -> None:
    """What lies beyond the axis is dotted along its edge, so that it is seen to be there."""
    beyond = numpy.abs(y) > limit
    inside = numpy.where(beyond, numpy.nan, y)
    if numpy.isfinite(inside).any():
        axes.plot(*decimate(x, inside, style.GROUPS), color=colour, label=label)
    for sign in (-1, 1):
        edge = numpy.where(beyond & (sign * y > 0), sign * limit, numpy.nan)
        if numpy.isfinite(edge).any():
            axes.plot(*decimate(x, edge, style.GROUPS), color=colour, linewidth=1.5,
                      linestyle=(0, (1, 1)), clip_on=False, label="outside the axis")


def _draw_welds(axes: Axes, recording: Recording, truth: Table) -> None:
    try:
        welds = recording.table("welds.csv", "the tables of a crawler have it", ["stamp"])
    except Missing as reason:
        recording.note(f"position_error has no welds: {reason}")
        return
    places = _interpolated(welds.numbers["stamp"], truth, "odometer_distance")
    axes.plot(places, numpy.full(len(places), 0.02), "|", color=style.BLACK, markersize=5,
              markeredgewidth=0.6, transform=axes.get_xaxis_transform(), label="weld")


def _draw_events(axes: Axes, numbers: dict[str, numpy.ndarray], travelled: numpy.ndarray,
                 locked: numpy.ndarray) -> None:
    if locked.any():
        place = travelled[int(numpy.argmax(locked))]
        axes.axvline(place, color=style.GREEN, linewidth=0.8, linestyle=(0, (4, 2)))
        axes.annotate(f"locked from {place:.1f} m", (place, 1), (3, -7), xycoords=axes.get_xaxis_transform(),
                      textcoords="offset points", va="top", color=style.GREEN)
    for column, marker, colour, label in (
            ("double_slip_detected", "v", style.VERMILLION, "double slip"),
            ("tally_error_detected", "s", style.PURPLE, "tally error")):
        flags = numbers[column] != 0
        begins = flags & ~numpy.concatenate(([False], flags[:-1]))
        if begins.any():
            axes.plot(travelled[begins], numpy.full(begins.sum(), 0.97), marker, color=colour,
                      markersize=4, transform=axes.get_xaxis_transform(), label=label)
