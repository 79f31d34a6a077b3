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
    "bad sigma": style.GREEN,
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
_WHY = "the recorder of a crawler writes it"


def draw(recording: Recording) -> Figure:
    header = recording.header("fused.csv", _WHY)
    suffix = ".rejection"
    odometers = [name[:-len(suffix)] for name in header if name.endswith(suffix)]
    if "support" not in header:
        raise Missing(f"{recording.folder / 'fused.csv'} has no column 'support': it is of a fusion of "
                      "single readings, which the picture `readings` shows")
    healths = [f"{name}.health" for name in odometers if f"{name}.health" in header]
    table = recording.table("fused.csv", _WHY, ["stamp", "distance"],
                            ["status", "support", *(name + suffix for name in odometers), *healths])
    table.require_rising("stamp")
    return _picture(table, odometers)


class _Timeline:
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

    def bars(self, rows: numpy.ndarray, widened: bool = True) -> list[tuple[float, float]]:
        """(start, width) of the stretches of these rows."""
        least = self.shown * _SHORTEST if widened else 0.0
        return [(start, end - start)
                for start, end in stretches(self.times[rows], self._ends[rows], least)]


def _picture(table: Table, odometers: list[str]) -> Figure:
    timeline = _Timeline(table.numbers["stamp"])
    graph = _Support(table.texts["support"], len(odometers))
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


def _draw_odometers(axes: Axes, timeline: _Timeline, table: Table,
                    odometers: list[str]) -> list[tuple[str, str]]:
    """A band per odometer by the reason of rejection, a strip below it by its health. Gives the
    colour and meaning of what is there."""
    used: dict[tuple[str, str], None] = {}
    for place, name in enumerate(odometers):
        for column, meanings, top, height in ((".rejection", REJECTIONS, -0.4, 0.55),
                                              (".health", HEALTHS, 0.2, 0.2)):
            values = numpy.array(table.texts.get(name + column, [""] * len(table)))
            present = set(numpy.unique(values)) - {"", "ok"}
            unknown = sorted(present - set(meanings))
            for value in [*(known for known in meanings if known in present), *unknown]:
                colour = meanings.get(value, style.BLACK)
                bars = timeline.bars(values == value, widened=value != "none")
                axes.broken_barh(bars, (place + top, height), facecolors=colour)
                used[(colour, value)] = None
    axes.set_yticks(range(len(odometers)), odometers)
    axes.set_ylim(len(odometers) - 0.5, -0.5)
    axes.tick_params(left=False, labelbottom=False)
    axes.spines[["left", "bottom"]].set_visible(False)
    order = [*REJECTIONS, *HEALTHS]
    return sorted(used, key=lambda item: order.index(item[1]) if item[1] in order else len(order))


def _draw_rows(axes: Axes, timeline: _Timeline,
               rows: list[tuple[str, numpy.ndarray, numpy.ndarray]]) -> None:
    """A line per row: dark where all of it agrees, light and thin where a part does."""
    for place, (_, whole, part) in enumerate(rows):
        axes.broken_barh(timeline.bars(part, widened=False), (place - 0.1, 0.2), facecolors=style.SKY)
        axes.broken_barh(timeline.bars(whole, widened=False), (place - 0.22, 0.44),
                         facecolors=style.BLUE)
    axes.set_yticks(range(len(rows)), [label for label, _, _ in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_ylabel("pair" if len(rows[0][0]) > 2 else "supported")
    axes.tick_params(left=False, labelbottom=False)
    axes.spines[["left", "bottom"]].set_visible(False)


class _Support:
    """The column `support`, "1>2 2>1": who supports whom, odometers counted from 1."""

    def __init__(self, texts: list[str], odometers: int) -> None:
        self._odometers = odometers
        meanings = {text: set(text.split()) for text in set(texts)}
        self._edges = {
            (i, j): numpy.array([f"{i}>{j}" in meanings[text] for text in texts])
            for i in range(1, odometers + 1) for j in range(1, odometers + 1) if i != j}

    def rows(self) -> list[tuple[str, numpy.ndarray, numpy.ndarray]]:
        """Label, where it agrees wholly, where partly: per pair, or per odometer when they are many."""
        everyone = range(1, self._odometers + 1)
        if self._odometers <= MOST_PAIRED:
            return [(f"{i}–{j}", self._edges[i, j] & self._edges[j, i],
                     self._edges[i, j] ^ self._edges[j, i])
                    for i in everyone for j in everyone if i < j]
        result = []
        for j in everyone:
            supporters = sum(self._edges[i, j].astype(int) for i in everyone if i != j)
            most = 2 * supporters >= self._odometers - 1
            result.append((str(j), most, (supporters > 0) & ~most))
        return result


def _undecided_mark() -> Line2D:
    return Line2D([], [], marker="v", color=style.BLACK, markersize=3, linestyle="none")


def _legend(figure: Figure, used: list[tuple[str, str]], undecided: bool) -> None:
    handles: dict[str, object] = {}
    for colour, value in used:
        handles["believed" if value == "none" else value] = Patch(facecolor=colour)
    handles["agree"] = Patch(facecolor=style.BLUE)
    if undecided:
        handles["no consensus"] = (Patch(facecolor=style.YELLOW), _undecided_mark())
    style.legend_above(figure, list(handles.values()), list(handles), 4)
