# SPDX-License-Identifier: Apache-2.0
"""Which odometer was believed when: rejections, slips, and who agreed with whom."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from . import style
from .csv_table import Table
from .decimation import decimate, stretches
from .recording import Missing, Recording

# What is drawn later covers what is drawn before: the graver, the later. What there is one cause for
# has one colour, whether the fusion or the watch over the odometers' health says it.
REJECTIONS = {
    "none": style.PALE,
    "incomplete": style.YELLOW,
    "absent": style.GREY,
    "unsupported": style.ORANGE,
    "drifted": style.VERMILLION,
    "stuck": style.PURPLE,
    "marked invalid": style.SKY,
    "bad sigma": style.BLUE,
    "not a number": style.BLUE,
}
HEALTHS = {
    "silent": style.GREY,
    "worn": style.GREEN,
    "slipping": style.BLACK,
    "stuck": style.PURPLE,
    "bad values": style.BLUE,
}
MOST_PAIRED = 6
"""With more odometers the rows of the pairs would be too many: each odometer gets one row instead."""

_SHORTEST = 1 / 400
"""The least width of a stretch, as a share of the picture's."""
_SHADES = ("white", "#C3CCD4", "#93A0AC", "#66737F", "#38434E")
"""From no agreement to full."""
_COLUMNS = 400
"""Pieces of time that the agreement is averaged over."""
_WHY = "the tables of a crawler have it"


def draw(recording: Recording) -> Figure:
    header = recording.header("fused.csv", _WHY)
    suffix = ".rejection"
    odometers = [name[:-len(suffix)] for name in header if name.endswith(suffix)]
    if "support" not in header:
        raise Missing(f"{recording.folder / 'fused.csv'} has no column 'support': it is of a fusion of "
                      "single readings, which the picture `readings` shows")
    if not odometers:
        raise Missing(f"{recording.folder / 'fused.csv'} has no column NAME{suffix}, so no odometer")
    healths = [f"{name}.health" for name in odometers if f"{name}.health" in header]
    table = recording.table("fused.csv", _WHY, ["stamp", "distance"],
                            ["status", "support", *(name + suffix for name in odometers), *healths])
    table.require_rising("stamp")
    return _picture(table, odometers)


class Timeline:
    """Turns states per row into stretches of time."""

    def __init__(self, stamps: numpy.ndarray) -> None:
        seconds = stamps - stamps[0]
        steps = numpy.diff(seconds)
        usual = float(numpy.median(steps)) if steps.size else 1.0
        # A row says nothing of a silence that follows it.
        lasting = numpy.append(numpy.minimum(steps, 10 * usual), usual)
        self.length = max(float(seconds[-1] + usual), 1e-9)
        self.unit, self.label = style.time_axis(self.length)
        self.times = seconds / self.unit
        self._ends = (seconds + lasting) / self.unit

    @property
    def shown(self) -> float:
        return self.length / self.unit

    def bars(self, rows: numpy.ndarray | slice = slice(None)) -> list[tuple[float, float]]:
        """(start, width) of the stretches of these rows, all of them unless given."""
        least = self.shown * _SHORTEST
        return [(start, end - start)
                for start, end in stretches(self.times[rows], self._ends[rows], least)]

    def mean(self, values: numpy.ndarray, edges: numpy.ndarray) -> numpy.ndarray:
        """Of each piece between two edges: the mean over its time; 0 where nothing is recorded."""
        integral, recorded = (self._integral(part, edges) for part in (values, numpy.ones(len(values))))
        return numpy.divide(integral, recorded, out=numpy.zeros(len(edges) - 1), where=recorded > 0)

    def _integral(self, values: numpy.ndarray, edges: numpy.ndarray) -> numpy.ndarray:
        lasting = self._ends - self.times
        after = numpy.cumsum(values * lasting)
        knots = numpy.ravel(numpy.column_stack((self.times, self._ends)))
        integral = numpy.ravel(numpy.column_stack((after - values * lasting, after)))
        return numpy.diff(numpy.interp(edges, knots, integral))


def _picture(table: Table, odometers: list[str]) -> Figure:
    timeline = Timeline(table.numbers["stamp"])
    graph = Support(table.texts["support"], len(odometers))
    rows = graph.rows()
    heights = [0.34 * len(odometers), 0.13 * len(rows) + 0.05, 0.75]
    figure = style.figure(sum(heights) + 1.05)
    axes = figure.subplots(3, 1, sharex=True, height_ratios=heights)
    used = _draw_odometers(axes[0], timeline, table, odometers)
    _draw_rows(axes[1], timeline, rows)
    axes[2].plot(*decimate(timeline.times, table.numbers["distance"], style.GROUPS), color=style.BLUE)
    axes[2].set_ylabel("distance [m]")
    axes[2].set_xlabel(timeline.label)
    axes[2].set_xlim(0, timeline.shown)
    undecided = numpy.array([status == "no consensus" for status in table.texts["status"]])
    for start, width in timeline.bars(undecided):
        for one in axes:
            one.axvspan(start, start + width, color=style.YELLOW, linewidth=0, zorder=0.5)
        mark = _undecided_mark()
        mark.set_data([start + width / 2], [-0.65])
        mark.set_clip_on(False)
        axes[0].add_line(mark)
    for one, letter in zip(axes, "abc"):
        style.label_panel(one, letter)
    figure.align_ylabels()
    _legend(figure, used, undecided.any())
    return figure


def _draw_odometers(axes: Axes, timeline: Timeline, table: Table,
                    odometers: list[str]) -> list[tuple[str, str]]:
    """A band per odometer by the reason of rejection, a strip below it by its health. Gives the
    colour and meaning of what is there."""
    used: dict[tuple[str, str], None] = {(REJECTIONS["none"], "none"): None}
    for place, name in enumerate(odometers):
        axes.broken_barh(timeline.bars(), (place - 0.4, 0.55), facecolors=REJECTIONS["none"])
        for column, meanings, top, height in ((".rejection", REJECTIONS, -0.4, 0.55),
                                              (".health", HEALTHS, 0.2, 0.2)):
            values = numpy.array(table.texts.get(name + column, [""] * len(table)))
            present = set(numpy.unique(values)) - {"", "none", "ok"}
            unknown = sorted(present - set(meanings))
            for value in [*(known for known in meanings if known in present), *unknown]:
                colour = meanings.get(value, style.BLACK)
                axes.broken_barh(timeline.bars(values == value), (place + top, height),
                                 facecolors=colour)
                used[(colour, value)] = None
    axes.set_yticks(range(len(odometers)), odometers)
    axes.set_ylim(len(odometers) - 0.5, -0.5)
    axes.tick_params(left=False, labelbottom=False)
    axes.spines[["left", "bottom"]].set_visible(False)
    order = [*REJECTIONS, *HEALTHS]
    return sorted(used, key=lambda item: order.index(item[1]) if item[1] in order else len(order))


def _draw_rows(axes: Axes, timeline: Timeline, rows: list[tuple[str, numpy.ndarray]]) -> None:
    """A line per row, the darker the more of it agrees."""
    edges = numpy.linspace(0, timeline.shown, _COLUMNS + 1)
    for place, (_, agreement) in enumerate(rows):
        shades = numpy.rint(timeline.mean(agreement, edges) * (len(_SHADES) - 1)).astype(int)
        for shade, colour in enumerate(_SHADES[1:], 1):
            pieces = numpy.flatnonzero(shades == shade)
            bars = [(start, end - start)
                    for start, end in stretches(edges[pieces], edges[pieces + 1], 0.0)]
            axes.broken_barh(bars, (place - 0.22, 0.44), facecolors=colour)
    axes.set_yticks(range(len(rows)), [label for label, _ in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_ylabel("pair" if len(rows[0][0]) > 2 else "supported")
    axes.tick_params(left=False, labelbottom=False)
    axes.spines[["left", "bottom"]].set_visible(False)


class Support:
    """The column `support`, "1>2 2>1": who supports whom, odometers counted from 1."""

    def __init__(self, texts: list[str], odometers: int) -> None:
        self._odometers = odometers
        self._rows = len(texts)
        meanings = {text: set(text.split()) for text in set(texts)}
        self._edges = {
            (i, j): numpy.array([f"{i}>{j}" in meanings[text] for text in texts], dtype=float)
            for i in range(1, odometers + 1) for j in range(1, odometers + 1) if i != j}

    def rows(self) -> list[tuple[str, numpy.ndarray]]:
        """Label and agreement, 0 to 1: of each pair, or, when there are many odometers or one, the
        share of the others that support each."""
        everyone = range(1, self._odometers + 1)
        if 2 <= self._odometers <= MOST_PAIRED:
            return [(f"{i}–{j}", (self._edges[i, j] + self._edges[j, i]) / 2)
                    for i in everyone for j in everyone if i < j]
        others = max(self._odometers - 1, 1)
        return [(str(j), sum((self._edges[i, j] for i in everyone if i != j),
                             numpy.zeros(self._rows)) / others) for j in everyone]


def _undecided_mark() -> Line2D:
    return Line2D([], [], marker="v", color=style.BLACK, markersize=3, linestyle="none")


def _legend(figure: Figure, used: list[tuple[str, str]], undecided: bool) -> None:
    handles: dict[str, object] = {}
    for colour, value in used:
        handles["believed" if value == "none" else value] = Patch(facecolor=colour)
    handles["agree"] = Patch(facecolor=_SHADES[-1])
    if undecided:
        handles["no consensus"] = (Patch(facecolor=style.YELLOW), _undecided_mark())
    style.legend_above(figure, list(handles.values()), list(handles), 4)
