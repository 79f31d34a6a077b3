# SPDX-License-Identifier: Apache-2.0
"""The camera of a recording, and its images."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy
import yaml

from ..csv_table import BadData
from ..recording import Recording

_LARGEST = 1 << 16


@dataclass
class Camera:
    """Pinhole behind a lens of ROS; pixel (0, 0) is the middle of the upper left one."""

    width: int
    height: int
    matrix: numpy.ndarray
    distortion: numpy.ndarray
    """k1, k2, p1, p2, k3, k4, k5, k6 of rational_polynomial, the last three 0 for plumb_bob; k1 to k4 of
    equidistant, then zeros."""
    equidistant: bool = False

    def project(self, points: numpy.ndarray) -> numpy.ndarray:
        """Pixels (n, 2) of points (n, 3) in the camera's frame; NaN where the camera does not look or
        the distortion model is far out of its range."""
        depth = numpy.where(points[:, 2] > 1e-3, points[:, 2], numpy.nan)
        x, y = points[:, 0] / depth, points[:, 1] / depth
        r2 = x * x + y * y
        if self.equidistant:
            k1, k2, k3, k4 = self.distortion[:4]
            r = numpy.sqrt(r2)
            theta = numpy.arctan(r)
            t2 = theta * theta
            angle = theta * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))))
            radial = numpy.divide(angle, r, out=numpy.ones_like(r), where=r > 1e-9)
            plane = numpy.stack((x * radial, y * radial, numpy.ones_like(x)))
        else:
            k1, k2, p1, p2, k3, k4, k5, k6 = self.distortion
            radial = ((1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6))))
            plane = numpy.stack((x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                                 y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y, numpy.ones_like(x)))
        pixels = (self.matrix @ plane)[:2].T
        pixels[r2 > self._largest_r2()] = numpy.nan
        return pixels

    def _largest_r2(self) -> float:
        """Somewhat beyond the corners of the image, seen without distortion; what the library uses of an
        equidistant lens."""
        if self.equidistant:
            return float(numpy.tan(numpy.radians(80)) ** 2)
        inverse = numpy.linalg.inv(self.matrix)
        corners = numpy.array([[0, 0, 1], [self.width, 0, 1], [0, self.height, 1],
                               [self.width, self.height, 1]], dtype=float)
        rays = corners @ inverse.T
        return 2.5 * float((rays[:, :2] ** 2).sum(axis=1).max())

    def contains(self, pixels: numpy.ndarray, margin: float = 0.0) -> numpy.ndarray:
        return ((pixels[:, 0] >= margin) & (pixels[:, 0] <= self.width - 1 - margin)
                & (pixels[:, 1] >= margin) & (pixels[:, 1] <= self.height - 1 - margin))


def read_camera(recording: Recording) -> Camera:
    """Raises Missing, and BadData naming the file."""
    path = recording.path("camera.yaml", "no calibration arrived")
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        matrix = numpy.array(content["camera_matrix"]["data"], dtype=float).reshape(3, 3)
        distortion = numpy.array(content["distortion_coefficients"]["data"], dtype=float)
        model = dict(content).get("distortion_model", "plumb_bob")
        camera = Camera(int(content["image_width"]), int(content["image_height"]), matrix,
                        numpy.resize(numpy.append(distortion, numpy.zeros(8)), 8),
                        model == "equidistant")
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, ValueError) as problem:
        raise BadData(f"{path}: not a calibration in the format of ROS: {problem!r}") from problem
    if model not in ("plumb_bob", "rational_polynomial", "equidistant"):
        raise BadData(f"{path}: distortion_model '{model}' is not known")
    if not numpy.isfinite(matrix).all() or matrix[0, 0] <= 0 or matrix[1, 1] <= 0:
        raise BadData(f"{path}: camera_matrix is not that of a camera")
    return camera


def read_pgm(path: Path) -> numpy.ndarray:
    """Rows of 8-bit grey. Raises BadData."""
    try:
        content = path.read_bytes()
    except OSError as problem:
        raise BadData(f"{path}: {problem.strerror}") from problem
    words = content.split(maxsplit=4)[:4]
    try:
        width, height, top = (int(word) for word in words[1:])
    except ValueError:
        raise BadData(f"{path}: not a binary PGM file") from None
    header = content.find(words[3], content.find(words[2], content.find(words[1], 2) + len(words[1]))
                          + len(words[2])) + len(words[3]) + 1
    if words[0] != b"P5" or top != 255 or not (0 < width <= _LARGEST and 0 < height <= _LARGEST):
        raise BadData(f"{path}: not a binary PGM file of 8 bits")
    pixels = numpy.frombuffer(content, numpy.uint8, offset=min(header, len(content)))
    if pixels.size < width * height:
        raise BadData(f"{path}: {pixels.size} pixels, and its header says {width} x {height}")
    return pixels[:width * height].reshape(height, width)
