# SPDX-License-Identifier: Apache-2.0
"""The subject `tracking`: the track of a pipe, and the arm that keeps it in view."""

from __future__ import annotations

from ..contents import Kind
from ..recording import Animation, Picture
from . import animation, arm, errors, image_track, overlay

KINDS = (
    Kind("tracking", "a tracked pipe and the arm", {"track.csv": frozenset({"u"})}, (
        Picture("particles", "the tracked pipe and the tracker's particles over three thermal images", overlay.draw),
        Picture("arm", "where the pipe was in the image, what the arm did, and its joints", arm.draw),
        Picture("tracking_errors", "how far the track was off over time, by each of its estimates", errors.draw),
        Animation("tracking", "thermal images with particles and track, and the arm's joints", animation.write),
    )),
    Kind("tracking", "a pipe tracked through images", {"track.csv": frozenset({"x_sd"})}, (
        Picture("track", "the pipe in the images: its middle, length and direction over time, and when it was lost",
                image_track.draw),
    )),
)
