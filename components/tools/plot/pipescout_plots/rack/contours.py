# SPDX-License-Identifier: Apache-2.0
"""The lines that a camera sees of a rack: contours of pipes, edges of supports, what hides them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy

from .camera import Camera
from .rack_file import Rack, Section, Support

SAMPLES = 240
"""Points along each line."""
_BEFORE = 0.999
"""A body hides a point when the ray meets it before this share of the way."""


@dataclass
class Line:
    """A line in the image, (n, 2), NaN where it is not seen; `hidden` marks what lies behind a body."""

    pixels: numpy.ndarray
    hidden: numpy.ndarray


def image_lines(rack: Rack, offsets: dict[str, float], camera: Camera, position: numpy.ndarray,
                rotation: numpy.ndarray) -> list[Line]:
    """`position`, `rotation`: of the camera's optical frame in the rack frame. Lines without any point
    in the image are left out."""
    sections = rack.sections(offsets)
    lines = []
    for points, own_section, own_support in _lines(rack, sections, position):
        pixels = camera.project((points - position) @ rotation)
        outside = ~camera.contains(pixels)
        if outside.all():
            continue
        pixels[outside & numpy.roll(outside, 1) & numpy.roll(outside, -1)] = numpy.nan
        lines.append(Line(pixels, _hidden(points, position, sections, rack.supports, own_section,
                                          own_support)))
    return lines


def _lines(rack: Rack, sections: list[Section],
           eye: numpy.ndarray) -> Iterator[tuple[numpy.ndarray, int | None, int | None]]:
    """Points, the section and the support that a line is on."""
    shares = numpy.linspace(0, 1, SAMPLES)[:, None]
    for number, section in enumerate(sections):
        for start, end in contour_lines(section, eye):
            yield start + shares * (end - start), number, None
    for number, support in enumerate(rack.supports):
        for start, end in support_edges(support, eye):
            yield start + shares * (end - start), None, number


def contour_lines(section: Section, eye: numpy.ndarray) -> list[tuple[numpy.ndarray, numpy.ndarray]]:
    """Both lines along which planes through the eye touch it: equations (10) to (14), and the same for a
    cone. None from within."""
    to_eye = eye - section.start
    along = float(to_eye @ section.direction)
    across = to_eye - along * section.direction
    distance = float(numpy.linalg.norm(across))
    slope = (section.radius_end - section.radius_start) / section.length
    cosine = (section.radius_start + slope * along) / distance if distance > 0 else numpy.inf
    if abs(cosine) >= 1:
        return []
    towards = across / distance
    aside = numpy.cross(section.direction, towards)
    sine = numpy.sqrt(1 - cosine * cosine)
    end = section.start + section.length * section.direction
    return [(section.start + section.radius_start * normal, end + section.radius_end * normal)
            for normal in (cosine * towards - sine * aside, cosine * towards + sine * aside)]


def support_edges(support: Support, eye: numpy.ndarray) -> list[tuple[numpy.ndarray, numpy.ndarray]]:
    """The edges with at least one face that looks at the eye."""
    faces = numpy.stack((eye < support.lowest, eye > support.highest))
    corners = numpy.stack((support.lowest, support.highest))
    edges = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for i in range(2):
            for j in range(2):
                if faces[i, first] or faces[j, second]:
                    start = support.lowest.copy()
                    start[first], start[second] = corners[i, first], corners[j, second]
                    end = start.copy()
                    end[axis] = support.highest[axis]
                    edges.append((start, end))
    return edges


def _hidden(points: numpy.ndarray, eye: numpy.ndarray, sections: list[Section],
            supports: list[Support], own_section: int | None, own_support: int | None) -> numpy.ndarray:
    rays = points - eye
    hidden = numpy.zeros(len(points), dtype=bool)
    for number, section in enumerate(sections):
        if number != own_section:
            hidden |= _meets_section(eye, rays, section)
    for number, support in enumerate(supports):
        if number != own_support:
            hidden |= _meets_box(eye, rays, support)
    return hidden


def _meets_section(eye: numpy.ndarray, rays: numpy.ndarray, section: Section) -> numpy.ndarray:
    """Whether eye + t ray, 0 < t < _BEFORE, meets the side of a section."""
    slope = (section.radius_end - section.radius_start) / section.length
    to_eye = eye - section.start
    eye_along = float(to_eye @ section.direction)
    eye_across = to_eye - eye_along * section.direction
    eye_radius = section.radius_start + slope * eye_along
    ray_along = rays @ section.direction
    ray_across = rays - ray_along[:, None] * section.direction
    a = (ray_across ** 2).sum(axis=1) - (slope * ray_along) ** 2
    b = ray_across @ eye_across - slope * ray_along * eye_radius
    c = float(eye_across @ eye_across) - eye_radius ** 2
    root = numpy.sqrt(numpy.maximum(b * b - a * c, 0))
    met = numpy.zeros(len(rays), dtype=bool)
    for sign in (-1, 1):
        with numpy.errstate(divide="ignore", invalid="ignore"):
            t = (-b + sign * root) / a
            along = eye_along + t * ray_along
            met |= (b * b > a * c) & (t > 0) & (t < _BEFORE) & (along > 0) & (along < section.length)
    return met


def _meets_box(eye: numpy.ndarray, rays: numpy.ndarray, support: Support) -> numpy.ndarray:
    with numpy.errstate(divide="ignore", invalid="ignore"):
        near = (support.lowest - eye) / rays
        far = (support.highest - eye) / rays
    entry = numpy.fmin(near, far).max(axis=1)
    leaving = numpy.fmax(near, far).min(axis=1)
    return (entry < leaving) & (entry > 0) & (entry < _BEFORE)
