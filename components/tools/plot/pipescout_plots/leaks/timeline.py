# SPDX-License-Identifier: Apache-2.0
"""What was seen in each thermal image, and when leaks were raised."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import style
from ..recording import Missing, Recording
from ..time_axis import TimeAxis

NUMBER_GAP = 0.04
"""Between leaks whose numbers are written, of the width: they do not touch."""


def draw(recording: Recording) -> Figure:
    table = recording.table("detections.csv", "no thermal image was looked at",
                            ["stamp", "pipes", "leaks", "largest_delta"], ["fault"])
    table.require_rising("stamp")
    stamps = table.numbers["stamp"]
    time = TimeAxis(float(stamps[0]), float(stamps[-1]))
    figure = style.figure(2.5)
    hottest, counts = figure.subplots(2, 1, sharex=True, height_ratios=(1.5, 1))
    hottest.plot(time(stamps), table.numbers["largest_delta"], ".", color=style.VERMILLION, markersize=2.5,
                 markeredgewidth=0, linestyle="", label="strongest leak in the image")
    hottest.axhline(0, color=style.BLACK, linewidth=0.4)
    hottest.set_ylabel("above sound pipe [K]")
    _mark_raised(hottest, time, recording)
    faults = numpy.array(table.texts["fault"], dtype=object) != ""
    for values, colour, label in ((table.numbers["pipes"], style.BLUE, "pipes in the image"),
                                  (table.numbers["leaks"], style.VERMILLION, "leaks in the image")):
        counts.step(time(stamps), values, where="post", color=colour, linewidth=0.6, label=label)
    if faults.any():
        counts.plot(time(stamps[faults]), numpy.full(faults.sum(), 0.96), "x", color=style.BLACK, markersize=3,
                    transform=counts.get_xaxis_transform(), linestyle="", label=f"{faults.sum()} images not usable")
    counts.set_ylim(bottom=0)
    counts.yaxis.get_major_locator().set_params(integer=True)
    counts.set_ylabel("number")
    time.limit(counts)
    counts.set_xlabel(time.label)
    figure.align_ylabels()
    style.legend_above(figure, *style.unique_legend(hottest, counts), 2)
    return figure


def _mark_raised(axes: Axes, time: TimeAxis, recording: Recording) -> None:
    """With their numbers above, as far as these do not touch."""
    try:
        events = recording.table("events.csv", "no leak was raised", ["stamp"], ["event", "leak"])
    except Missing as reason:
        recording.note(f"leak_timeline has no findings: {reason}")
        return
    raised = [(float(time(numpy.array(stamp))), leak) for stamp, event, leak in
              zip(events.numbers["stamp"], events.texts["event"], events.texts["leak"]) if event == "raised"]
    apart = NUMBER_GAP * float(time(numpy.array(time.end)))
    last = -numpy.inf
    for place, leak in raised:
        axes.axvline(place, color=style.PURPLE, linewidth=0.6, linestyle=(0, (3, 2)), label="leak raised, with its number")
        if place - last >= apart:
            axes.annotate(leak, (place, 1), (0, 1.5), xycoords=("data", "axes fraction"), textcoords="offset points",
                          ha="center", va="bottom", fontsize=6, color=style.PURPLE)
            last = place
