# SPDX-License-Identifier: Apache-2.0
"""What the command printed, and whether the texts of a picture can be read."""

from __future__ import annotations

from pathlib import Path

import numpy
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox
from pipescout_plots import style

_TOUCHES = 0.5
"""Points that neighbours may share: the boxes of texts have room around the letters."""


def paths(out: str) -> list[Path]:
    """Of the pictures, each printed with what it shows."""
    result = []
    for line in out.splitlines():
        path, shows = line.split("\t")
        assert len(shows) > 10, line
        result.append(Path(path))
    return result


def unreadable(figure: Figure) -> list[str]:
    """Texts that are cut by the border of the picture, or cover each other."""
    style.settle(figure)
    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()
    page = figure.bbox
    boxes = [(text, box) for text, box in _texts(figure, renderer)]
    pixel = figure.dpi / 72
    faults = [f"'{text}' is cut" for text, box in boxes
              if box.x0 < page.x0 - pixel or box.y0 < page.y0 - pixel or box.x1 > page.x1 + pixel
              or box.y1 > page.y1 + pixel]
    for k, (text, box) in enumerate(boxes):
        for other, near in boxes[k + 1:]:
            both = Bbox.intersection(box, near)
            if both is not None and min(both.width, both.height) > _TOUCHES * pixel:
                faults.append(f"'{text}' covers '{other}'")
    return faults


def _texts(figure: Figure, renderer):
    for axes in figure.get_axes():
        if not axes.get_visible():
            continue
        shown = [*axes.texts, axes.title, axes._left_title, axes._right_title, axes.xaxis.offsetText,
                 axes.yaxis.offsetText]
        if axes.axison:
            shown += [axes.xaxis.label, axes.yaxis.label]
            shown += _tick_labels(axes.xaxis, axes.get_xlim()) + _tick_labels(axes.yaxis, axes.get_ylim())
        for text in shown:
            yield from _box(text, renderer)
    for legend in [*figure.legends, *(axes.get_legend() for axes in figure.get_axes() if axes.get_legend())]:
        for text in legend.get_texts():
            yield from _box(text, renderer)
    for text in figure.texts:
        yield from _box(text, renderer)


def _tick_labels(axis, limits) -> list:
    low, high = sorted(limits)
    room = 1e-6 * (high - low)
    return [label for tick in axis.get_major_ticks() for label in (tick.label1, tick.label2)
            if low - room <= tick.get_loc() <= high + room]


def _box(text, renderer):
    if text.get_visible() and text.get_text().strip():
        box = text.get_window_extent(renderer)
        if numpy.isfinite(box.get_points()).all() and box.width > 0:
            yield text.get_text(), box
