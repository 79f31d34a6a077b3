# SPDX-License-Identifier: Apache-2.0
"""Pictures of what `pipescout reproduce in-pipe --json` wrote."""

from __future__ import annotations

import json
import math
import re
import textwrap
from pathlib import Path

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import style
from .csv_table import BadData
from .recording import Missing, Recording

DECIBELS = re.compile(r"detector at (-?\d+(?:\.\d+)?) dB")
"""In the name of a study: the signal-to-noise ratio that its rows are of."""
ERRORS = ("median", "95 %", "worst")
BEND_ERROR = re.compile(r"(.+): error of a bend, (median|95 %|worst), m")
"""A measure: the rule, and what of ERRORS."""
MEASURES = (
    ("welds found, %", "welds found [%]", 1.0),
    ("false ones per km", "false per km", 1.0),
    ("error of the position, 95 %, m", "95 % error [mm]", 1000.0),
)


def draw_curve(recording: Recording) -> Figure:
    """Welds found, false alarms and error of the weld detector over the signal-to-noise ratio."""
    curves = detector_curves(read_rows(recording.file))
    shown = [measure for measure in MEASURES if measure[0] in curves]
    if not shown:
        raise Missing(f"{recording.file} has no rows of the weld detector at several dB")
    figure = style.figure(1.05 * len(shown) + 0.55)
    panels = numpy.atleast_1d(figure.subplots(len(shown), 1, sharex=True))
    for axes, (measure, label, factor), letter in zip(panels, shown, "abc"):
        _draw_curve(axes, curves[measure], factor)
        axes.set_ylabel(label)
        if len(shown) > 1:
            style.label_panel(axes, letter)
    panels[-1].set_xlabel("peak signal-to-noise ratio [dB]")
    figure.align_ylabels()
    style.legend_above(figure, *panels[0].get_legend_handles_labels(), 2)
    return figure


def detector_curves(rows: list[dict]) -> dict[str, list[tuple[float, float, list[float]]]]:
    """By measure, rising: decibels, the value over all seeds, and the values of the seeds."""
    curves: dict[str, list[tuple[float, float, list[float]]]] = {}
    for row in rows:
        found = DECIBELS.search(str(row.get("study", "")))
        value = number_of(row.get("value"))
        if found and math.isfinite(value):
            seeds = [number_of(seed) for seed in row.get("per_seed") or []]
            curves.setdefault(str(row.get("measure")), []).append((float(found[1]), value, seeds))
    return {measure: sorted(points) for measure, points in curves.items() if len(points) > 1}


def draw_rules(recording: Recording) -> Figure:
    """Error of the fused distance in a bend, by the rule that fuses the wheels: the paper's Figure 3 for bends."""
    rules = bend_errors(read_rows(recording.file))
    if not rules:
        raise Missing(f"{recording.file} has no rows of the rules in bends")
    figure = style.figure(0.24 * len(rules) + 0.75)
    axes = figure.subplots()
    for (name, colour, marker) in ((name, style.SEQUENCE[k], style.MARKERS[k]) for k, name in enumerate(ERRORS)):
        points = [(1000.0 * errors[name], line) for line, errors in enumerate(rules.values()) if name in errors]
        axes.plot([point[0] for point in points], [point[1] for point in points], linestyle="", color=colour,
                  marker=marker, markersize=4, label=name)
    for line, errors in enumerate(rules.values()):
        axes.plot([1000.0 * min(errors.values()), 1000.0 * max(errors.values())], [line, line],
                  color=style.PALE_GREY, linewidth=0.8, zorder=0)
    axes.set_yticks(range(len(rules)), [textwrap.fill(rule, 28) for rule in rules])
    axes.set_ylim(len(rules) - 0.5, -0.5)
    axes.set_xscale("log")
    axes.set_xlabel("error of a bend [mm]")
    axes.grid(axis="x", color=style.PALE, linewidth=0.5)
    axes.set_axisbelow(True)
    style.legend_above(figure, *axes.get_legend_handles_labels(), 3)
    return figure


def bend_errors(rows: list[dict]) -> dict[str, dict[str, float]]:
    """m, by rule, in the order of the rows, and by what of ERRORS it is."""
    rules: dict[str, dict[str, float]] = {}
    for row in rows:
        found = BEND_ERROR.fullmatch(str(row.get("measure")))
        value = number_of(row.get("value"))
        if row.get("study") == "Bends, the rules compared" and found and value > 0:
            rules.setdefault(found[1], {})[found[2]] = value
    return rules


def draw_figures(recording: Recording) -> Figure:
    """The figures as a table: over all seeds, the mean of the seeds, their worst."""
    rows = [row for row in read_rows(recording.file) if row.get("figure")]
    if not rows:
        raise Missing(f"{recording.file} has no rows with figures")
    figure = style.figure(0.135 * (len(rows) + 1) + 0.1)
    axes = figure.subplots()
    axes.set_axis_off()
    axes.set(xlim=(0, 1), ylim=(len(rows) + 0.5, -0.5))
    for column, (key, title) in enumerate((("value", "all seeds"), ("mean", "mean"), ("worst", "worst"))):
        place = 0.72 + 0.14 * column
        axes.text(place, 0, title, ha="right", va="center")
        for line, row in enumerate(rows, 1):
            axes.text(place, line, _cell(row.get(key)), ha="right", va="center")
    axes.text(0, 0, "figure", va="center")
    axes.axhline(0.5, color=style.BLACK, linewidth=0.6)
    for line, row in enumerate(rows, 1):
        axes.text(0, line, str(row["figure"]), va="center")
    return figure


def _draw_curve(axes: Axes, points: list[tuple[float, float, list[float]]], factor: float) -> None:
    decibels = [point[0] for point in points]
    values = [factor * point[1] for point in points]
    spread = [[seed for seed in point[2] if math.isfinite(seed)] or [point[1]] for point in points]
    axes.fill_between(decibels, [factor * min(seeds) for seeds in spread],
                      [factor * max(seeds) for seeds in spread], color=style.PALE_BLUE, linewidth=0,
                      label="least to most of the seeds")
    axes.plot(decibels, values, color=style.BLUE, marker="o", markersize=2.5, label="all seeds")
    axes.set_xticks(decibels)
    axes.grid(axis="y", color=style.PALE, linewidth=0.5)
    axes.set_axisbelow(True)


def read_rows(path: Path) -> list[dict]:
    """Of what `pipescout reproduce TABLE --json` wrote. Raises BadData."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as problem:
        raise BadData(f"{path}: {problem}") from problem
    rows = content.get("rows") if isinstance(content, dict) else None
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise BadData(f"{path}: no list 'rows' of objects, as `pipescout reproduce --json` writes it")
    return rows


def number_of(value: object) -> float:
    """NaN for what is not a number."""
    return float(value) if isinstance(value, (int, float)) else math.nan


def _cell(value: object) -> str:
    number = number_of(value)
    return f"{number:.3g}" if math.isfinite(number) else "\N{EN DASH}"
