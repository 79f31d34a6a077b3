# SPDX-License-Identifier: Apache-2.0
"""The subject `rack`: pictures of flights over a pipe rack."""

from __future__ import annotations

from ..contents import Kind
from ..recording import Animation, Picture
from . import animation, errors, flight, map, offsets, overlay

KINDS = (
    Kind("rack", "a flight over a rack", {"pose.csv": frozenset(), "offsets.csv": frozenset()}, (
        Picture("overlay", "the model of the rack at the estimated pose over three images: its lines lie on the "
                "pipes' edges if the pose is right", overlay.draw),
        Picture("map", "the rack from above with the path flown, way-points and hot spots", map.draw),
        Picture("flight", "position, orientation and velocity over time: estimated, commanded, true", flight.draw),
        Picture("pose_errors", "how far the pose was off over time, and how far it says it may be", errors.draw),
        Picture("offsets", "where the pipes are across the rack, as estimated over time", offsets.draw),
        Animation("animation", "images with the model over them, and the path over the rack", animation.write),
    )),
    Kind("rack", "camera poses over a rack", {"poses.csv": frozenset({"stamp", "rotation_x_standard_deviation"})}, (
        Picture("map", "the rack from above with the path of the camera", map.draw),
        Picture("flight", "position, orientation and velocity of the camera over time", flight.draw),
    )),
)
