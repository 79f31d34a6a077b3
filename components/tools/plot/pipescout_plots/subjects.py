# SPDX-License-Identifier: Apache-2.0
"""All that is drawn. A folder's pictures are drawn and printed in this order."""

from __future__ import annotations

from . import odometry, reproduction
from .estimator import subject as estimator
from .leaks import subject as leaks
from .navigation import subject as navigation
from .rack import subject as rack
from .rack import table1
from .recording import Picture
from .tracking import subject as tracking

KINDS = (*odometry.KINDS, *navigation.KINDS, *rack.KINDS, *leaks.KINDS, *tracking.KINDS, *estimator.KINDS)

REPRODUCTION: tuple[tuple[str | None, Picture], ...] = (
    ("odometry", Picture("detector_curve", "welds found, false alarms and error of the detector over the "
                         "signal-to-noise ratio", reproduction.draw_curve)),
    ("odometry", Picture("rules_in_bends", "error of the fused distance in bends, by the rule that fuses",
                         reproduction.draw_rules)),
    ("rack", Picture("table1", "errors of the pose by pipes and texture points: the paper's Table I and ours",
                     table1.draw)),
    (None, Picture("figures", "the figures as a table", reproduction.draw_figures)),
)
"""By subject, or of each: of what `pipescout reproduce --json` wrote."""
