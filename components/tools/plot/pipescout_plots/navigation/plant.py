# SPDX-License-Identifier: Apache-2.0
"""The plant from above: map, graph, obstacles that were seen, coverage, plans, and the way that was driven."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from .. import style
from ..findings import draw_findings, read_findings
from ..labels import place_labels
from ..recording import Missing, Recording
from . import map_files

LARGEST_HEIGHT = 5.0
"""Inches."""
FROM_ABOVE = (0, 1)
BESIDE_MAP = 0.15
"""m: what is seen so near a cell of the map is that of the map."""
PALE_OBSTACLE = "#F2BFA3"
"""Of vermillion."""
SEEN_OFTEN = 3
"""Times; what is seen less often moves, is far, or is noise."""
STANDS = 0.02
"""m/s"""
LONG_STAND = 2.0
"""s"""


def draw(recording: Recording) -> Figure:
    plan = recording.table("plan.csv", "no path was planned", ["plan", "x", "y"])
    grid = map_files.find_grid(recording.mission)
    ways = {label: _way(recording, name) for name, label in (("localisation.csv", "estimated"),
                                                               ("truth.csv", "driven"))}
    low, high = _frame(grid, plan, ways.values())
    width = style.COLUMN - 0.55
    height = min(width * float((high[1] - low[1]) / (high[0] - low[0])), LARGEST_HEIGHT)
    figure = style.figure(height + style.LABELS)
    axes = figure.subplots()
    if grid is not None:
        shades = LinearSegmentedColormap.from_list("map", ["#FFFFFF", style.GREY])
        axes.imshow(grid.shade, cmap=shades, vmin=0, vmax=1, extent=grid.extent, interpolation="nearest",
                    zorder=0)
    _draw_graph(axes, recording)
    _draw_obstacles(axes, recording, grid)
    for number in numpy.unique(plan.numbers["plan"]):
        rows = plan.numbers["plan"] == number
        axes.plot(plan.numbers["x"][rows], plan.numbers["y"][rows], color=style.ORANGE, linewidth=1.6,
                  alpha=0.6, zorder=4, label="planned")
    for label, way in ways.items():
        if way is not None:
            colour, line = (style.BLUE, "-") if label == "driven" else (style.BLACK, (0, (1.2, 2.2)))
            axes.plot(way[0], way[1], color=colour, linewidth=0.8, linestyle=line, zorder=5, label=label)
    _draw_stands(axes, recording)
    findings = read_findings(recording)
    draw_findings(axes, findings, FROM_ABOVE, "leak")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    style.legend_above(figure, *style.unique_legend(axes), 3, grow=True)
    place_labels(axes, findings.labels(FROM_ABOVE), findings.marks(FROM_ABOVE))
    return figure


def _way(recording: Recording, name: str):
    try:
        table = recording.table(name, "no pose arrived", ["x", "y"])
    except Missing:
        return None
    return table.numbers["x"], table.numbers["y"]


def _frame(grid, plan, ways) -> tuple[numpy.ndarray, numpy.ndarray]:
    if grid is not None:
        left, right, bottom, top = grid.extent
        return numpy.array((left, bottom)), numpy.array((right, top))
    points = [numpy.stack((plan.numbers["x"], plan.numbers["y"]))]
    points += [numpy.stack(way) for way in ways if way is not None]
    places = numpy.concatenate(points, axis=1)
    low, high = numpy.nanmin(places, axis=1), numpy.nanmax(places, axis=1)
    middle, half = (low + high) / 2, numpy.maximum((high - low) / 2 + 1, 2)
    half = numpy.maximum(half, [half[1] / 2, half[0] / 3])
    return middle - half, middle + half


def _draw_graph(axes: Axes, recording: Recording) -> None:
    """Coverage is drawn over the edges whose pipes were seen."""
    edges = map_files.find_edges(recording.mission)
    for edge in edges:
        axes.plot(*edge.points.T, color=style.PALE_BLUE, linewidth=0.8, marker=".", markersize=3, zorder=1,
                  label="route graph")
    try:
        coverage = recording.table("coverage.csv", "no pipe was seen", ["row", "from", "to", "sharp"])
    except Missing:
        return
    by_number = {edge.number: edge for edge in edges}
    for row in numpy.unique(coverage.numbers["row"]):
        edge = by_number.get(int(row))
        if edge is None or len(edge.points) < 2:
            continue
        rows = coverage.numbers["row"] == row
        for sharp, colour, label in ((1, style.GREEN, "pipe seen sharp"), (0, style.VERMILLION, "pipe not sharp")):
            mine = rows & (coverage.numbers["sharp"] == sharp)
            ends = [_along(edge.points, coverage.numbers[end][mine]) for end in ("from", "to")]
            gaps = numpy.full_like(ends[0], numpy.nan)
            pieces = numpy.stack((*ends, gaps), axis=1).reshape(-1, 2)
            if len(pieces):
                axes.plot(*pieces.T, color=colour, linewidth=3, solid_capstyle="butt", alpha=0.5, zorder=2,
                          label=label)


def _along(points: numpy.ndarray, metres: numpy.ndarray) -> numpy.ndarray:
    lengths = numpy.concatenate(([0.0], numpy.cumsum(numpy.hypot(*numpy.diff(points, axis=0).T))))
    return numpy.stack([numpy.interp(metres, lengths, points[:, k]) for k in (0, 1)], axis=-1)


def _draw_obstacles(axes: Axes, recording: Recording, grid) -> None:
    """Those that the map does not show."""
    try:
        table = recording.table("obstacles.csv", "no obstacle was seen", ["x", "y", "times"])
    except Missing:
        return
    x, y = table.numbers["x"], table.numbers["y"]
    unknown = ~_is_mapped(grid, x, y)
    for rows, colour, label in ((unknown & (table.numbers["times"] >= SEEN_OFTEN), style.VERMILLION, "obstacle, not in map"),
                                (unknown & (table.numbers["times"] < SEEN_OFTEN), PALE_OBSTACLE, f"seen less than {SEEN_OFTEN} times")):
        if rows.any():
            axes.plot(x[rows], y[rows], "s", color=colour, markersize=1, linestyle="", zorder=3, label=label)


def _is_mapped(grid, x: numpy.ndarray, y: numpy.ndarray) -> numpy.ndarray:
    if grid is None:
        return numpy.zeros(len(x), dtype=bool)
    left, right, bottom, top = grid.extent
    height, width = grid.shade.shape
    cell = (right - left) / width
    reach = max(1, round(BESIDE_MAP / cell))
    mapped = numpy.zeros(len(x), dtype=bool)
    for dx in range(-reach, reach + 1):
        for dy in range(-reach, reach + 1):
            column = numpy.floor((x - left) / cell).astype(int) + dx
            row = numpy.floor((top - y) / cell).astype(int) + dy
            inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
            mapped[inside] |= grid.shade[row[inside], column[inside]] > 0.5
    return mapped


def _draw_stands(axes: Axes, recording: Recording) -> None:
    """Where it waited on its way, and backed up."""
    try:
        states = recording.table("state.csv", "the navigator said nothing", ["stamp", "speed"], ["state", "drive"])
        way = recording.table("localisation.csv", "no pose arrived", ["stamp", "x", "y"])
    except Missing:
        return
    stamps = states.numbers["stamp"]
    waiting = numpy.array([state == "driving" and drive == "waiting"
                           for state, drive in zip(states.texts["state"], states.texts["drive"])])
    waiting &= numpy.abs(states.numbers["speed"]) < STANDS
    edges = numpy.flatnonzero(numpy.diff(numpy.concatenate(([False], waiting, [False])).astype(int)))
    places = [stamps[begin] for begin, end in zip(edges[::2], edges[1::2])
              if stamps[min(end, len(stamps) - 1)] - stamps[begin] >= LONG_STAND]
    if places:
        axes.plot(numpy.interp(places, way.numbers["stamp"], way.numbers["x"]),
                  numpy.interp(places, way.numbers["stamp"], way.numbers["y"]), "v", color=style.BLACK,
                  markersize=3.5, linestyle="", zorder=6, label="waited")
