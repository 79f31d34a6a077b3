# SPDX-License-Identifier: Apache-2.0
"""The subject `estimator`: pictures of what a state estimator said, and why."""

from __future__ import annotations

from ..contents import Kind
from ..recording import Picture
from . import biases, consistency, errors, residuals, sources, trajectory, uncertainty

KINDS = (
    Kind("estimator", "a state estimator", {"estimate.csv": frozenset(), "factors.csv": frozenset(),
                                            "sources.csv": frozenset()}, (
        Picture("trajectory", "the path from above: estimated, true if that is known, and the GPS fixes if there are any", trajectory.draw),
        Picture("errors", "how far position and heading were off over time, and how far they say they may be",
                errors.draw),
        Picture("consistency", "whether the stated uncertainty is right: the line belongs into the band",
                consistency.draw),
        Picture("residuals", "how well each measurement fitted, and which were refused", residuals.draw),
        Picture("sources", "which sensor was believed when", sources.draw),
        Picture("biases", "errors of IMU and odometer as estimated", biases.draw),
    )),
    Kind("estimator", "the trajectory of a recording", {"trajectory.csv": frozenset({"x_deviation"})}, (
        Picture("trajectory", "the path from above with its uncertainty", trajectory.draw),
        Picture("uncertainty", "height, and the stated standard deviation of the position, over time",
                uncertainty.draw),
    )),
)
