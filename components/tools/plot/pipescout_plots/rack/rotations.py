# SPDX-License-Identifier: Apache-2.0
"""Rotations as arrays of shape (..., 3, 3), angles in radians."""

from __future__ import annotations

import numpy

# Columns are the axes of a camera that looks straight down from a vehicle (x forward, y left, z up), the
# upper border of its image ahead: image right is the vehicle's right.
DOWNWARD_CAMERA = numpy.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


def from_quaternions(q: numpy.ndarray) -> numpy.ndarray:
    """Of quaternions (..., 4) in the order x, y, z, w, whose norms need not be 1."""
    x, y, z, w = numpy.moveaxis(q / numpy.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return numpy.moveaxis(numpy.array(rows), (0, 1), (-2, -1))


def from_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> numpy.ndarray:
    """Rz(yaw) Ry(pitch) Rx(roll), REP 103."""
    (cr, cp, cy), (sr, sp, sy) = numpy.cos([roll, pitch, yaw]), numpy.sin([roll, pitch, yaw])
    about_x = numpy.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = numpy.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = numpy.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def yaw_pitch_roll(rotations: numpy.ndarray) -> numpy.ndarray:
    """ZYX Euler angles (..., 3)."""
    yaw = numpy.arctan2(rotations[..., 1, 0], rotations[..., 0, 0])
    pitch = numpy.arcsin(numpy.clip(-rotations[..., 2, 0], -1, 1))
    roll = numpy.arctan2(rotations[..., 2, 1], rotations[..., 2, 2])
    return numpy.stack((yaw, pitch, roll), axis=-1)


def logarithm(rotations: numpy.ndarray) -> numpy.ndarray:
    """Rotation vectors (..., 3); exact away from half a turn."""
    axis = 0.5 * numpy.stack((rotations[..., 2, 1] - rotations[..., 1, 2],
                              rotations[..., 0, 2] - rotations[..., 2, 0],
                              rotations[..., 1, 0] - rotations[..., 0, 1]), axis=-1)
    sine = numpy.linalg.norm(axis, axis=-1)
    cosine = 0.5 * (numpy.trace(rotations, axis1=-2, axis2=-1) - 1)
    angle = numpy.arctan2(sine, cosine)
    factor = numpy.where(sine > 1e-9, angle / numpy.maximum(sine, 1e-9), 1.0)
    return axis * factor[..., None]


def interpolate(times: numpy.ndarray, quaternions: numpy.ndarray, wanted: numpy.ndarray) -> numpy.ndarray:
    """Rotations at `wanted` from close samples: linear in the quaternion. NaN outside."""
    signs = numpy.ones(len(times))
    signs[1:] = numpy.cumprod(numpy.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0, -1.0, 1.0))
    aligned = quaternions * signs[:, None]
    columns = [numpy.interp(wanted, times, aligned[:, k], left=numpy.nan, right=numpy.nan)
               for k in range(4)]
    return from_quaternions(numpy.stack(columns, axis=-1))
