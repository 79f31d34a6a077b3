# SPDX-License-Identifier: Apache-2.0
"""The subject `odometry`: odometers, welds and places in the pipe; lists of welds and ledgers."""

from __future__ import annotations

from . import eddy_current, joints, ledger_alignment, position_error, readings, support_graph
from .contents import ANY_NAME, Kind
from .recording import Picture

_NONE: frozenset[str] = frozenset()

KINDS = (
    Kind("odometry", "readings of odometers", {"readings.csv": _NONE, "fused.csv": frozenset({"fusion_set"})}, (
        Picture("readings", "each odometer's readings with the offsets added, the fused distance, and which "
                "readings were rejected", readings.draw),
    )),
    Kind("odometry", "a run in a pipe", {"fused.csv": frozenset({"support"}), "positions.csv": _NONE,
                                         "welds.csv": _NONE, "eddy_current.csv": _NONE}, (
        Picture("support_graph", "which odometer was believed when, and the fused distance", support_graph.draw),
        Picture("position_error", "how far the position in the pipe was off, and how far it says it may be",
                position_error.draw),
        Picture("eddy_current", "the signal along the pipe and the welds found in it, two of them enlarged",
                eddy_current.draw),
    )),
    Kind("odometry", "an alignment with a weld ledger",
         {ANY_NAME: frozenset({"run_chainage", "ledger_chainage", "difference"})}, (
        Picture("ledger_alignment", "how the run's odometer departs from the ledger, weld by weld",
                ledger_alignment.draw),
    )),
    Kind("odometry", "a weld ledger", {ANY_NAME: frozenset({"id", "chainage_m", "joint_length_m"})}, (
        Picture("ledger", "the joints of the pipe by their lengths, and how certain their welds are",
                joints.draw_ledger),
    )),
    Kind("odometry", "a list of welds", {ANY_NAME: frozenset({"Log distance [m]", "Feature type", "confidence"})}, (
        Picture("welds", "the joints between the welds found by their lengths, and how certain each weld is",
                joints.draw_welds),
    )),
)
