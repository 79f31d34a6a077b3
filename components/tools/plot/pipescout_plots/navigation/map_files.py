# SPDX-License-Identifier: Apache-2.0
"""Reads the map of a mission folder: an occupancy grid of map_server, and a route graph in GeoJSON."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy
import yaml
from PIL import Image

from ..csv_table import BadData


@dataclass(frozen=True)
class Grid:
    shade: numpy.ndarray
    """0 free to 1 occupied, row 0 at the top."""
    extent: tuple[float, float, float, float]
    """m: left, right, bottom, top."""


@dataclass(frozen=True)
class Edge:
    number: int
    points: numpy.ndarray
    pipe: bool


def find_grid(mission: Path) -> Grid | None:
    """The first below the mission folder; none when there is no map. Raises BadData."""
    for path in sorted(mission.rglob("*.yaml")):
        content = _yaml(path)
        if isinstance(content, dict) and "image" in content and "resolution" in content:
            return _grid(path, content)
    return None


def find_edges(mission: Path) -> list[Edge]:
    """Of the first route graph below the mission folder; none when there is none. Raises BadData."""
    for path in sorted(mission.rglob("*.geojson")):
        edges = _edges(path)
        if edges:
            return edges
    return []


def _yaml(path: Path):
    try:
        return yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return None  # another's file


def _grid(path: Path, content: dict) -> Grid:
    try:
        resolution = float(content["resolution"])
        x, y, yaw = (float(value) for value in content["origin"])
        with Image.open(path.parent / str(content["image"])) as image:
            pixels = numpy.asarray(image.convert("L"), dtype=float) / 255
    except (OSError, KeyError, TypeError, ValueError) as problem:
        raise BadData(f"{path}: {problem}") from problem
    if abs(yaw) > 1e-6:
        raise BadData(f"{path}: origin: grids that are turned are not drawn")
    height, width = pixels.shape
    shade = pixels if content.get("negate") else 1 - pixels
    return Grid(shade, (x, x + width * resolution, y, y + height * resolution))


def _edges(path: Path) -> list[Edge]:
    try:
        features = json.loads(path.read_text(encoding="utf-8")).get("features", [])
        edges = []
        for feature in features:
            properties = feature.get("properties") or {}
            geometry = feature.get("geometry") or {}
            if "startid" not in properties or geometry.get("type") not in ("LineString", "MultiLineString"):
                continue
            lines = geometry["coordinates"] if geometry["type"] == "MultiLineString" else [geometry["coordinates"]]
            points = numpy.array([point[:2] for line in lines for point in line], dtype=float)
            side = (properties.get("metadata") or {}).get("pipe_side", "none")
            edges.append(Edge(int(properties["id"]), points, side != "none"))
        return edges
    except (OSError, UnicodeDecodeError, AttributeError, KeyError, TypeError, ValueError) as problem:
        raise BadData(f"{path}: {problem}") from problem
