# SPDX-License-Identifier: Apache-2.0
"""What all pictures share: sizes, colours, and how they are written, the same bytes every time."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path

import matplotlib
import matplotlib.style
import numpy
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

COLUMN = 3.5
"""Width of a column of a paper with two, in inches."""

_LAYOUTS = 2
LABELS = 0.5
"""Inches below a panel, for the labels of its x axis."""

# Okabe and Ito, Color Universal Design (2008): told apart by all, also with colour-blind eyes.
BLACK = "#000000"
ORANGE = "#E69F00"
SKY = "#56B4E9"
GREEN = "#009E73"
YELLOW = "#F0E442"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#8C8C8C"
PALE = "#DCE4EA"
PALE_BLUE = "#BFDDF2"
PALE_GREY = "#C4C4C4"

SEQUENCE = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK, GREY)
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")

GROUPS = 600
"""Runs of samples that a long recording is reduced to: more than a column can show."""

_SETTINGS = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 7,
    "axes.labelsize": 7,
    "axes.titlesize": 7,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "legend.fontsize": 6.5,
    "legend.frameon": False,
    "legend.handlelength": 1.4,
    "legend.columnspacing": 1.1,
    "legend.handletextpad": 0.5,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "lines.linewidth": 0.8,
    "lines.solid_joinstyle": "round",
    "patch.linewidth": 0,
    "hatch.linewidth": 0.4,
    "savefig.dpi": 300,
    # Text stays text, which can be searched and edited; ids come from content, not from chance.
    "svg.fonttype": "none",
    "svg.hashsalt": "pipescout",
}


def begin() -> None:
    """The style of this project, whatever the user's own is."""
    matplotlib.rcdefaults()
    matplotlib.rcParams.update(_SETTINGS)


def figure(height: float) -> Figure:
    """An empty picture of a column's width; height in inches."""
    result = Figure(figsize=(COLUMN, height), layout="constrained")
    FigureCanvasAgg(result)
    result.get_layout_engine().set(w_pad=0.02, h_pad=0.02, hspace=0.03, wspace=0.03)
    return result


def label_panel(axes: Axes, letter: str) -> None:
    """Above the labels of the y axis."""
    axes.annotate(f"({letter})", (0, 1), (-29, 2), xycoords="axes fraction", textcoords="offset points")


def legend_above(picture: Figure, handles: Sequence, labels: Sequence[str], columns: int, grow: bool = False) -> None:
    """A legend over all panels, which make room for it; `grow`: the picture does, for panels that have a scale."""
    size = matplotlib.rcParams["legend.fontsize"]
    rows = -(-len(labels) // columns)
    inches = (rows * 1.45 + 0.4) * size / 72
    if grow:
        picture.set_figheight(picture.get_figheight() + inches)
    picture.get_layout_engine().set(rect=(0, 0, 1, 1 - inches / picture.get_figheight()))
    picture.legend(handles, labels, loc="upper center", ncols=columns, borderaxespad=0.2, borderpad=0.1)


def unique_legend(*panels: Axes) -> tuple[list, list[str]]:
    """Each label once, in the order in which they come."""
    entries: dict[str, object] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels()):
            entries.setdefault(label, handle)
    return list(entries.values()), list(entries)


def time_axis(seconds: float) -> tuple[float, str]:
    """What to divide seconds by, and the axis' label, for a recording of this length."""
    for longest, unit, name in ((900, 1.0, "s"), (3 * 3600, 60.0, "min")):
        if seconds <= longest:
            return unit, f"time [{name}]"
    return 3600.0, "time [h]"


def symmetric_limit(values: numpy.ndarray, margin: float = 1.15) -> float:
    """Half the height of an axis about zero that shows all finite values; 1 when there are none."""
    finite = numpy.abs(values[numpy.isfinite(values)])
    top = float(finite.max()) * margin if finite.size else 0.0
    return top if top > 0 else 1.0


def log_axis(axes: Axes) -> None:
    """A logarithmic y axis of one or two decades with numbers at 1, 2 and 5 of each."""
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=6))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_locator(NullLocator())


def write(picture: Figure, path: Path) -> None:
    """Writes SVG or PNG by the suffix; the file appears as a whole. Raises OSError."""
    metadata = {"Date": None, "Creator": "pipescout plot"} if path.suffix == ".svg" else {
        "Software": "pipescout plot"}
    buffer = io.BytesIO()
    settle(picture)
    picture.savefig(buffer, format=path.suffix[1:], metadata=metadata)
    write_bytes(buffer.getvalue(), path)


def write_bytes(content: bytes, path: Path) -> None:
    """The file appears as a whole, in a folder that is made for it. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except OSError:
        os.unlink(temporary)
        raise


def settle(picture: Figure) -> None:
    """Lays the panels out for good, with rounded edges: the last digits of what the layout's solver
    finds depend on how many pictures it has done before."""
    # A panel with a scale moves in its place when that is laid out, and its labels with it: once more.
    for _ in range(_LAYOUTS if any(axes.get_aspect() != "auto" for axes in picture.get_axes()) else 1):
        picture.draw_without_rendering()
    picture.set_layout_engine("none")
    for axes in picture.get_axes():
        axes.set_position([round(edge, 5) for edge in axes.get_position(original=True).bounds])


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
