# SPDX-License-Identifier: Apache-2.0
"""Long recordings in few points, with every extreme kept: nothing that stands out gets lost."""

from __future__ import annotations

import numpy


def decimate(x: numpy.ndarray, y: numpy.ndarray, groups: int) -> tuple[numpy.ndarray, numpy.ndarray]:
    """At most four points of each of `groups` runs of consecutive samples: its first, lowest, highest
    and last one, in their order. A gap (NaN) of whole runs stays a gap. Short input stays as it is."""
    if len(x) <= 4 * groups:
        return x, y
    edges = _edges(len(x), groups)
    kept = set()
    for start, end in zip(edges[:-1], edges[1:]):
        kept.update((start, end - 1))
        part = y[start:end]
        if not numpy.isnan(part).all():
            kept.update((start + int(numpy.nanargmin(part)), start + int(numpy.nanargmax(part))))
    order = numpy.array(sorted(kept))
    return x[order], y[order]


def envelope(x: numpy.ndarray, low: numpy.ndarray, high: numpy.ndarray,
             groups: int) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
    """A band by runs of consecutive samples: from their lowest `low` to their highest `high`, at the
    first and the last of each run."""
    if len(x) <= 2 * groups:
        return x, low, high
    edges = _edges(len(x), groups)
    ends = numpy.ravel(numpy.column_stack((edges[:-1], edges[1:] - 1)))
    lowest = numpy.fmin.reduceat(low, edges[:-1])
    highest = numpy.fmax.reduceat(high, edges[:-1])
    return x[ends], numpy.repeat(lowest, 2), numpy.repeat(highest, 2)


def _edges(samples: int, groups: int) -> numpy.ndarray:
    return numpy.linspace(0, samples, groups + 1).astype(int)


def one_way_pieces(x: numpy.ndarray) -> list[slice]:
    """Slices in which x never turns back; neighbours share their end. NaN belongs to either."""
    pieces = []
    start, direction = 0, 0.0
    for k, step in enumerate(numpy.sign(numpy.diff(x))):
        if step * direction < 0:
            pieces.append(slice(start, k + 1))
            start, direction = k, 0.0
        if step in (-1, 1):
            direction = step
    return [*pieces, slice(start, len(x))]


def stretches(starts: numpy.ndarray, ends: numpy.ndarray,
              least: float) -> list[tuple[float, float]]:
    """The union of intervals with rising starts, none of them shorter than `least`: a short one is
    widened about its middle, so that it can be seen."""
    short = ends - starts < least
    middle = (starts + ends) / 2
    starts = numpy.where(short, middle - least / 2, starts)
    ends = numpy.where(short, middle + least / 2, ends)
    joined: list[tuple[float, float]] = []
    for start, end in sorted(zip(starts.tolist(), ends.tolist())):
        if joined and start <= joined[-1][1] + 1e-9:
            joined[-1] = (joined[-1][0], max(end, joined[-1][1]))
        else:
            joined.append((start, end))
    return joined
