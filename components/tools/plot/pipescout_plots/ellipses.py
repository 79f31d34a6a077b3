# SPDX-License-Identifier: Apache-2.0
"""Ellipses of uncertainty along a path, magnified so that they can be seen."""

from __future__ import annotations

import numpy
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse

from . import style

ELLIPSES = 14


def draw_ellipses(axes: Axes, places: numpy.ndarray, deviations: numpy.ndarray, correlation: numpy.ndarray,
                  size: float) -> None:
    """Of two standard deviations at some of `places` (n, 2), whose axes and those of `deviations` (n, 2)
    are those of the panel. The usual one gets a radius of about `size`; none is made smaller."""
    # Not at the ends: the first place is as uncertain as what it was started from.
    rows = numpy.unique(numpy.linspace(0, len(places) - 1, 2 * ELLIPSES + 1)[1::2].astype(int))
    rows = rows[numpy.isfinite(deviations[rows]).all(axis=1) & (deviations[rows] > 0).all(axis=1)]
    if not rows.size:
        return
    times = magnification(deviations[rows], size)
    for k, row in enumerate(rows):
        sx, sy = deviations[row]
        shared = numpy.nan_to_num(correlation[row]) * sx * sy
        variances, axes_of = numpy.linalg.eigh([[sx * sx, shared], [shared, sy * sy]])
        lengths = 4 * times * numpy.sqrt(numpy.maximum(variances, 0))
        x, y = axes_of[:, 1]
        axes.add_patch(Ellipse(places[row], lengths[1], lengths[0],
                               angle=float(numpy.degrees(numpy.arctan2(y, x))), facecolor=style.SKY,
                               alpha=0.45, zorder=4.5, linewidth=0,
                               label=None if k else "2σ" if times == 1 else f"2σ, {times:.0f} times as large"))


def magnification(deviations: numpy.ndarray, size: float) -> float:
    """1, 2 or 5 times a power of ten that makes the larger ones about as large as `size`."""
    wanted = size / (2 * float(numpy.median(deviations.max(axis=1))))
    power = 10.0 ** numpy.floor(numpy.log10(max(wanted, 1.0)))
    return float(max(step * power for step in (1, 2, 5) if step * power <= max(wanted, 1.0)))
