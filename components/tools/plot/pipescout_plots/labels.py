# SPDX-License-Identifier: Apache-2.0
"""Labels of points, placed so that they cover neither each other nor the points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.transforms import Bbox

from . import style

_MARK = 3.0
"""Points: half the size of a mark."""
_APART = 2.0
"""Points between labels: two numbers side by side must not be read as one."""
_PLACES = tuple((dx * reach, dy * reach) for reach in (1.0, 2.2, 3.6)
                for dx, dy in ((1, 1), (1, -1), (-1, 1), (-1, -1), (0, 1.3), (0, -1.3), (1.3, 0), (-1.3, 0)))
"""Where a label may be, from its point, in the order of preference: multiples of _STEP."""
_STEP = 4.0
"""Points."""


@dataclass(frozen=True)
class Label:
    x: float
    y: float
    text: str
    colour: str
    size: float = 6.0


def place_labels(axes: Axes, labels: Sequence[Label], marks: Sequence[tuple[float, float]] = ()) -> None:
    """After all else of the picture is drawn: lays the picture out for good. `marks`: other points that are
    to stay visible. A label that has no free place has the one where it covers least."""
    style.settle(axes.figure)
    axes.figure.draw_without_rendering()
    renderer = axes.figure.canvas.get_renderer()
    pixel = axes.figure.dpi / 72
    points = axes.transData.transform([(label.x, label.y) for label in labels] + list(marks))
    half = _MARK * pixel
    taken = [Bbox([(x - half, y - half), (x + half, y + half)]) for x, y in points]
    panel = axes.get_window_extent(renderer)
    taken += [text.get_window_extent(renderer) for text in axes.texts if text.get_text()]
    for label in labels:
        text = axes.annotate(label.text, (label.x, label.y), (0, 0), textcoords="offset points", fontsize=label.size,
                             color=label.colour, zorder=12)
        best = None
        for dx, dy in _PLACES:
            text.set(ha="left" if dx > 0 else "right" if dx < 0 else "center",
                     va="bottom" if dy > 0 else "top" if dy < 0 else "center")
            text.xyann = (dx * _STEP, dy * _STEP)
            box = text.get_window_extent(renderer)
            covered = sum(_common(box, other) for other in taken) + _outside(box, panel)
            if best is None or covered < best[0]:
                best = (covered, text.get_ha(), text.get_va(), text.xyann, box)
            if covered == 0:
                break
        _, ha, va, where, box = best
        text.set(ha=ha, va=va)
        text.xyann = where
        if max(abs(where[0]), abs(where[1])) > 2 * _STEP:
            axes.annotate("", (label.x, label.y), where, textcoords="offset points",
                          arrowprops={"arrowstyle": "-", "color": label.colour, "linewidth": 0.4,
                                      "shrinkA": 0, "shrinkB": _MARK}, zorder=11)
        taken.append(box.padded(_APART * pixel))


def _common(a: Bbox, b: Bbox) -> float:
    both = Bbox.intersection(a, b)
    return 0.0 if both is None else both.width * both.height


def _outside(box: Bbox, panel: Bbox) -> float:
    return box.width * box.height - _common(box, panel)
