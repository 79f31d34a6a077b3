# SPDX-License-Identifier: Apache-2.0
"""The joints of a pipe by their lengths: of a weld ledger, and of a list of welds that an inspection gave."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import style
from .csv_table import BadData, read_header
from .decimation import decimate
from .recording import Missing, Recording

_UNSURE = 0.9
"""Confidence of a weld below which it is marked: of ten of them one may be none."""


def draw_ledger(recording: Recording) -> Figure:
    """Rows are welds and other features (docs/weld_ledger.md); joints are between welds."""
    header = read_header(recording.file)
    optional = [name for name in ("chainage_sd_m", "joint_length_sd_m") if name in header]
    table = recording.list(["chainage_m", "joint_length_m", *optional], ["kind"] if "kind" in header else [])
    kinds = table.texts.get("kind", [""] * len(table))
    welds = numpy.array([kind.strip().lower() in ("", "weld") for kind in kinds])
    if not welds.any():
        raise Missing(f"{table.path} has no weld")
    columns = {name: values[welds] for name, values in table.numbers.items()}
    chainage = columns["chainage_m"]
    figure, upper, lower, unit = _panels(chainage, "chainage")
    _draw_joints(upper, chainage / unit, columns["joint_length_m"])
    for kind in dict.fromkeys(kind for kind in kinds if kind.strip().lower() not in ("", "weld")):
        rows = numpy.array(kinds) == kind
        upper.plot(table.numbers["chainage_m"][rows] / unit, numpy.full(rows.sum(), 0.03), "^", color=style.PURPLE,
                   markersize=3, transform=upper.get_xaxis_transform(), label=kind)
    for name, colour, label in (("joint_length_sd_m", style.VERMILLION, "of the joint's length"),
                                ("chainage_sd_m", style.BLUE, "of the weld's chainage")):
        if name in columns:
            lower.plot(*decimate(chainage / unit, columns[name], style.GROUPS), color=colour, label=label)
    style.log_axis(lower)
    lower.set_ylabel("standard\ndeviation [m]")
    return _finished(figure, upper, lower)


def draw_welds(recording: Recording) -> Figure:
    table = recording.list(["Log distance [m]", "confidence"], ["Feature type"])
    welds = numpy.array([kind.strip().lower() == "weld" for kind in table.texts["Feature type"]])
    distance, confidence = table.numbers["Log distance [m]"][welds], table.numbers["confidence"][welds]
    if not distance.size:
        raise Missing(f"{table.path} has no row whose 'Feature type' is 'Weld'")
    if (numpy.diff(distance) < 0).any():
        raise BadData(f"{table.path}: column 'Log distance [m]': welds are not in the order of their distance")
    figure, upper, lower, unit = _panels(distance, "log distance")
    _draw_joints(upper, distance / unit, numpy.append(numpy.diff(distance), numpy.nan))
    unsure = confidence < _UNSURE
    for rows, colour, label in ((~unsure, style.BLUE, "weld"), (unsure, style.VERMILLION, f"confidence below {_UNSURE}")):
        if rows.any():
            lower.plot(distance[rows] / unit, confidence[rows], ".", color=colour, markersize=3.5, markeredgewidth=0,
                       linestyle="", label=label)
    lower.set_ylim(0, 1.05)
    lower.set_ylabel("confidence [–]")
    return _finished(figure, upper, lower)


def _panels(chainage: numpy.ndarray, what: str) -> tuple[Figure, Axes, Axes, float]:
    """And the unit of the axis, in metres."""
    unit, name = (1000.0, "km") if numpy.ptp(chainage) > 5000 else (1.0, "m")
    figure = style.figure(2.6)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(1.4, 1))
    lower.set_xlabel(f"{what} [{name}]")
    return figure, upper, lower, unit


def _draw_joints(axes: Axes, chainage: numpy.ndarray, lengths: numpy.ndarray) -> None:
    """Each from its weld to the next. A length that stands out is a weld that was missed, or is none."""
    joints = numpy.isfinite(lengths[:-1])
    if len(chainage) < 2 or not joints.any():
        return
    starts, ends, high = chainage[:-1][joints], chainage[1:][joints], lengths[:-1][joints]
    gaps = numpy.full(len(starts), numpy.nan)
    axes.plot(numpy.column_stack((starts, ends, gaps)).ravel(), numpy.column_stack((high, high, gaps)).ravel(),
              color=style.BLUE, linewidth=1.2, solid_capstyle="butt", label="joint")
    middle = float(numpy.median(high))
    axes.axhline(middle, color=style.GREY, linewidth=0.5, linestyle=(0, (3, 2)), label=f"median, {middle:.2f} m")
    axes.margins(y=0.15)
    axes.set_ylabel("length of joint [m]")


def _finished(figure: Figure, upper: Axes, lower: Axes) -> Figure:
    figure.align_ylabels()
    for axes, letter in zip((upper, lower), "ab"):
        style.label_panel(axes, letter)
    style.legend_above(figure, *style.unique_legend(upper, lower), 3)
    return figure
