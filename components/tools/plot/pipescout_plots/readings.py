# SPDX-License-Identifier: Apache-2.0
"""Single readings of redundant odometers and what they were fused to: the paper's experiment."""

from __future__ import annotations

import numpy
import yaml
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from . import style
from .csv_table import Table, read_header
from .recording import Missing, Recording
from .support_graph import REJECTIONS

_WHY = "the tables of consensus fusion have it"


def draw(recording: Recording) -> Figure:
    path = recording.path("readings.csv", _WHY)
    suffix = ".standard_deviation"
    odometers = [name[:-len(suffix)] for name in read_header(path) if name.endswith(suffix)]
    readings = recording.table("readings.csv", _WHY, ["reading", *odometers])
    if not odometers:
        raise Missing(f"{path} has no column NAME{suffix}, so no odometer")
    rejections = [f"{name}.rejection" for name in odometers]
    fused = recording.table("fused.csv", _WHY, ["reading", "distance", "standard_deviation"],
                            ["fusion_set", *rejections])
    return _picture(readings, fused, odometers, _offsets(recording, odometers))


def _offsets(recording: Recording, odometers: list[str]) -> list[float]:
    """What the fusion added to the readings of each odometer, as mission.yaml has it."""
    path = recording.mission / "mission.yaml"
    try:
        mission = yaml.safe_load(path.read_text(encoding="utf-8"))
        found = [component["parameters"]["offsets"] for component in mission["components"]
                 if component["type"] == "pipescout::OdometryFusion"]
        if len(found) != 1:
            raise ValueError(f"{len(found)} fusions")
        offsets = [float(value) for value in found[0]] or [0.0] * len(odometers)
        if len(offsets) != len(odometers):
            raise ValueError(f"{len(offsets)} offsets for {len(odometers)} odometers")
        return offsets
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError) as problem:
        recording.note(f"{path}: the offsets of the odometers are not known ({problem}); the "
                               "readings are drawn without")
        return [0.0] * len(odometers)


def _picture(readings: Table, fused: Table, odometers: list[str], offsets: list[float]) -> Figure:
    heights = [1.5, 0.16 * len(odometers)]
    figure = style.figure(sum(heights) + 0.85)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=heights)
    _draw_distances(upper, readings, fused, odometers, offsets)
    _draw_sets(lower, fused, odometers)
    style.label_panel(upper, "a")
    style.label_panel(lower, "b")
    handles, labels = upper.get_legend_handles_labels()
    more, names = lower.get_legend_handles_labels()
    unique = dict(zip(labels + names, handles + more))
    style.legend_above(figure, list(unique.values()), list(unique), 4)
    return figure


def _draw_distances(axes: Axes, readings: Table, fused: Table, odometers: list[str],
                    offsets: list[float]) -> None:
    x, distance = fused.numbers["reading"], fused.numbers["distance"]
    axes.errorbar(x, distance, 2 * fused.numbers["standard_deviation"], fmt="_", color=style.BLACK,
                  markersize=7, markeredgewidth=1.2, elinewidth=3, ecolor=style.PALE_GREY,
                  label="fused ±2σ", zorder=1)
    for place, (name, offset) in enumerate(zip(odometers, offsets)):
        apart = 0.5 * ((place + 0.5) / len(odometers) - 0.5)
        axes.plot(readings.numbers["reading"] + apart, readings.numbers[name] + offset,
                  style.MARKERS[place % len(style.MARKERS)],
                  color=style.SEQUENCE[place % len(style.SEQUENCE)], markersize=3, linestyle="none",
                  label=name)
    axes.set_ylabel("distance [m]")


def _draw_sets(axes: Axes, fused: Table, odometers: list[str]) -> None:
    """A dot where the odometer's reading is in the fusion set, a cross in the colour of the reason
    where it is not."""
    x = fused.numbers["reading"]
    for place, name in enumerate(odometers):
        reasons = numpy.array(fused.texts[f"{name}.rejection"])
        for reason in sorted(set(reasons), key=[*REJECTIONS, *sorted(set(reasons))].index):
            rows = reasons == reason
            fine = reason == "none"
            axes.plot(x[rows], numpy.full(rows.sum(), place), "o" if fine else "x", markersize=3.5,
                      color=style.BLACK if fine else REJECTIONS.get(reason, style.BLACK),
                      linestyle="none", label="in the fusion set" if fine else reason)
    axes.set_yticks(range(len(odometers)), odometers)
    axes.set_ylim(len(odometers) - 0.5, -0.5)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=12))
    axes.set_xlabel("reading")
