# SPDX-License-Identifier: Apache-2.0
"""Reads a rack of pipes from its YAML file (docs/rack_file.md) for drawing; the localizer judges it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy
import yaml

from ..csv_table import BadData
from ..recording import Recording
from .flight_data import of_images


@dataclass
class Section:
    """A cylinder, or a truncated cone."""

    start: numpy.ndarray
    direction: numpy.ndarray
    length: float
    radius_start: float
    radius_end: float
    pipe: int

    def moved(self, offset: float) -> Section:
        return Section(self.start + [offset, 0, 0], self.direction, self.length, self.radius_start,
                       self.radius_end, self.pipe)


@dataclass
class Pipe:
    name: str
    start: numpy.ndarray
    """On its axis, in the rack frame, metres."""
    direction: numpy.ndarray
    radii: list[tuple[float, float]]
    """Metres along the pipe, radius there; linear in between."""

    @property
    def length(self) -> float:
        return self.radii[-1][0]

    @property
    def largest_radius(self) -> float:
        return max(radius for _, radius in self.radii)


@dataclass
class Support:
    name: str
    lowest: numpy.ndarray
    highest: numpy.ndarray


@dataclass
class Rack:
    pipes: list[Pipe]
    supports: list[Support] = field(default_factory=list)

    def sections(self, offsets: dict[str, float]) -> list[Section]:
        """`offsets`: by name of the pipe, metres along x."""
        result = []
        for number, pipe in enumerate(self.pipes):
            for (begin, first), (end, last) in zip(pipe.radii[:-1], pipe.radii[1:]):
                if end > begin:
                    section = Section(pipe.start + begin * pipe.direction, pipe.direction, end - begin,
                                      first, last, number)
                    result.append(section.moved(offsets.get(pipe.name, 0.0)))
        return result


def read_rack(recording: Recording) -> Rack:
    """Raises Missing, and BadData naming file and line."""
    return parse_rack(recording.path("rack.yaml", "a copy of the rack file there is drawn" if of_images(recording) else
                                     "its composition names none under summary.rack.rack"))


class _Mapping(dict):
    """Knows its line, from 1."""

    line = 0


class _Loader(yaml.SafeLoader):
    pass


def _construct(loader: _Loader, node: yaml.MappingNode) -> _Mapping:
    result = _Mapping(loader.construct_mapping(node, deep=True))
    result.line = node.start_mark.line + 1
    return result


_Loader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _construct)


def parse_rack(path: Path) -> Rack:
    """Raises BadData naming file and line."""
    try:
        content = yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as problem:
        raise BadData(f"{path}: {problem}") from problem
    if not isinstance(content, _Mapping):
        raise BadData(f"{path}: not a rack: neither 'row' nor 'pipes' nor 'supports'")
    reader = _Reader(path)
    pipes = reader.row(reader.entries(content, "row"))
    for key in ("pipes", "vessels"):
        pipes += [reader.pipe(entry) for entry in reader.entries(content, key)]
    if not pipes:
        raise BadData(f"{path}: no pipes")
    return Rack(pipes, [reader.support(entry) for entry in reader.entries(content, "supports")])


class _Reader:
    def __init__(self, path: Path) -> None:
        self._path = path

    def row(self, entries: list[_Mapping]) -> list[Pipe]:
        """The left-most line of the first one is x = 0, the lowest lines of all are on z = 0."""
        pipes: list[Pipe] = []
        edge = 0.0
        for entry in entries:
            radii = self._radii(entry)
            largest = max(radius for _, radius in radii)
            if pipes:
                edge += self._number(entry, "gap", entry.get("gap", 0.1))
            pipes.append(Pipe(self._name(entry), numpy.array([edge + largest, 0.0, largest]),
                              numpy.array([0.0, 1.0, 0.0]), radii))
            edge += 2 * largest
        return pipes

    def pipe(self, entry: _Mapping) -> Pipe:
        direction = self._vector(entry, "direction")
        length = float(numpy.linalg.norm(direction))
        if length == 0:
            self._refuse(entry, "direction", "is zero")
        return Pipe(self._name(entry), self._vector(entry, "start"), direction / length,
                    self._radii(entry))

    def support(self, entry: _Mapping) -> Support:
        return Support(self._name(entry), self._vector(entry, "lowest_corner"),
                       self._vector(entry, "highest_corner"))

    def entries(self, content: _Mapping, key: str) -> list[_Mapping]:
        entries = content.get(key) or []
        if not isinstance(entries, list) or not all(isinstance(entry, _Mapping) for entry in entries):
            self._refuse(content, key, "is not a list of mappings")
        return entries

    def _radii(self, entry: _Mapping) -> list[tuple[float, float]]:
        if "radii" not in entry:
            radius = self._number(entry, "radius", entry.get("radius"))
            radii = [(0.0, radius), (self._number(entry, "length", entry.get("length")), radius)]
        else:
            radii = [(self._number(place, "along", place.get("along")),
                      self._number(place, "radius", place.get("radius")))
                     for place in self.entries(entry, "radii")]
        places = [place for place, _ in radii]
        if len(radii) < 2 or places != sorted(places) or places[-1] <= places[0]:
            self._refuse(entry, "radii" if "radii" in entry else "length", "leads nowhere")
        if min(radius for _, radius in radii) <= 0:
            self._refuse(entry, "radius", "is not above 0")
        return radii

    def _name(self, entry: _Mapping) -> str:
        if not isinstance(entry.get("name"), str):
            self._refuse(entry, "name", "is not text")
        return entry["name"]

    def _vector(self, entry: _Mapping, key: str) -> numpy.ndarray:
        values = entry.get(key)
        if not isinstance(values, list) or len(values) != 3:
            self._refuse(entry, key, "is not a list of three numbers")
        return numpy.array([self._number(entry, key, value) for value in values])

    def _number(self, entry: _Mapping, key: str, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            self._refuse(entry, key, "is not a finite number")
        return float(value)

    def _refuse(self, entry: _Mapping, key: str, why: str) -> NoReturn:
        raise BadData(f"{self._path}: line {entry.line}: '{key}' {why}")
