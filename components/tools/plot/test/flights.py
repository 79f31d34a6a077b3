# SPDX-License-Identifier: Apache-2.0
"""Flights over a rack, made as `pipescout summary` makes them, with images of a small ray caster."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy
from missions import write_csv

START = 2000.0
LEVEL = numpy.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""Axes of a camera that looks straight down, the upper border of its image ahead along vehicle x."""

RACK = """\
row:
  - name: P1
    radii:
      - {along: 0, radius: 0.15}
      - {along: 4.85, radius: 0.15}
      - {along: 5.15, radius: 0.20}
      - {along: 10, radius: 0.20}
  - {name: P2, radius: 0.15, length: 10, gap: 0.10}
  - {name: P3, radius: 0.20, length: 10, gap: 0.10}
  - {name: P4, radius: 0.18, length: 10, gap: 0.10}
pipes:
  - {name: P5, start: [-1.5, 6.5, 0.55], direction: [1, 0, 0], radius: 0.15, length: 5}
supports:
  - {name: B1, lowest_corner: [-0.3, 4.0, -0.2], highest_corner: [2.06, 4.2, 0]}
  - {name: B2, lowest_corner: [-0.3, 5.8, -0.2], highest_corner: [2.06, 6.0, 0]}
"""
PIPES = (  # start, direction, length, radius at its start and at its end
    ((0.20, 0.0, 0.20), (0, 1, 0), 4.85, 0.15, 0.15), ((0.20, 4.85, 0.20), (0, 1, 0), 0.3, 0.15, 0.20),
    ((0.20, 5.15, 0.20), (0, 1, 0), 4.85, 0.20, 0.20), ((0.65, 0.0, 0.15), (0, 1, 0), 10, 0.15, 0.15),
    ((1.10, 0.0, 0.20), (0, 1, 0), 10, 0.20, 0.20), ((1.58, 0.0, 0.18), (0, 1, 0), 10, 0.18, 0.18),
    ((-1.5, 6.5, 0.55), (1, 0, 0), 5, 0.15, 0.15))
BEAMS = (((-0.3, 4.0, -0.2), (2.06, 4.2, 0)), ((-0.3, 5.8, -0.2), (2.06, 6.0, 0)))
TRUE_OFFSETS = {"P1": 0.0, "P2": 0.0, "P3": 0.01, "P4": 0.0, "P5": 0.0}
"""Metres; the images show the pipes where the rack file has them."""
WAY_POINTS = ((0.9, 5.0, 3.0, 1.5708), (1.9, 6.0, 3.0, 1.7708), (1.9, 3.5, 3.0, 1.3708),
              (1.9, 3.5, 2.5, 1.3708))
CAMERA = """\
image_width: {width}
image_height: {height}
camera_name: camera
camera_matrix:
  rows: 3
  cols: 3
  data: [{f}, 0, {cu}, 0, {f}, {cv}, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [{k1}, 0, 0, 0, 0]
"""
POSE = ["stamp", "x", "y", "z", "qx", "qy", "qz", "qw", "roll", "pitch", "yaw"]
AXES = ["x", "y", "z", "rotation_x", "rotation_y", "rotation_z"]
DEVIATIONS = [f"{axis}_standard_deviation" for axis in AXES]


@dataclass
class Options:
    seconds: float = 40.0
    rate: float = 25.0
    width: int = 360
    image_period: float = 2.0
    k1: float = 0.0
    seed: int = 1


def flight(mission: Path, **how) -> Path:
    """Four way-points under gusts, a loss from 20 to 21.2 s. Gives the folder of the data."""
    options = Options(**how)
    chance = numpy.random.default_rng(options.seed)
    data = mission / "rack"
    data.mkdir(parents=True)
    times = numpy.arange(int(options.seconds * options.rate)) / options.rate
    position, yaw, pitch, roll, command = _path(times, options.seconds, chance)
    (mission / "mission.yaml").write_text(
        "components:\n"
        "  - type: \"pipescout::RackSimulation\"\n    name: rack_simulation\n    parameters:\n"
        f"      rack: r.yaml\n      offsets: {list(TRUE_OFFSETS.values())}\n"
        "  - type: \"pipescout::VisualServo\"\n    name: visual_servo\n    parameters:\n"
        f"      way_points: {[value for point in WAY_POINTS for value in point]}\n"
        "summary:\n  rack.rack: r.yaml\n")
    (data / "rack.yaml").write_text(RACK)
    camera = {"width": options.width, "height": options.width * 2 // 3, "f": options.width * 0.875,
              "cu": options.width / 2, "cv": options.width / 3, "k1": options.k1}
    (data / "camera.yaml").write_text(CAMERA.format(**camera))
    rotations = [_rotation(*angles) @ LEVEL for angles in zip(roll, pitch, yaw)]
    write_csv(data / "truth.csv", POSE, [_pose_row(*row) for row in zip(times, position, rotations)])
    _write_poses(data, times, position, rotations, chance)
    _write_offsets(data, times, chance)
    write_csv(data / "command.csv", ["stamp"] + [f"{kind}_{axis}" for kind in ("linear", "angular")
                                                 for axis in "xyz"],
              [(f"{START + time:.9f}", *row) for time, row in zip(times, command)])
    write_csv(data / "way_points.csv", ["stamp", "done", "of", "message"],
              [(f"{START + time:.9f}", k, 4, f'"{k} of 4 way-points reached, 0 missed"') for k, time in
               enumerate(numpy.linspace(0.05, 0.95, 4) * options.seconds, 1)])
    _write_images(data, times, position, rotations, camera, options)
    return data


def _lost(time: float) -> bool:
    return 20.0 <= time < 21.2


def _path(times, seconds: float, chance):
    """Cubic steps between the way-points, gusts on position and attitude."""
    stops = numpy.linspace(0.05, 0.95, 4) * seconds
    points = numpy.array(WAY_POINTS)
    shares = numpy.clip((times[:, None] - stops[:-1] - 1) / (numpy.diff(stops) - 2), 0, 1)
    steps = 3 * shares ** 2 - 2 * shares ** 3
    planned = points[0] + steps @ numpy.diff(points, axis=0)
    gusts = numpy.stack([_coloured(len(times), chance, 40) for _ in range(5)], axis=-1)
    position = planned[:, :3] + gusts[:, :3] * [0.02, 0.02, 0.01]
    yaw = planned[:, 3] + 0.01 * gusts[:, 3]
    velocity = numpy.gradient(planned, times, axis=0)
    cosine, sine = numpy.cos(yaw), numpy.sin(yaw)
    forward = cosine * velocity[:, 0] + sine * velocity[:, 1]
    left = cosine * velocity[:, 1] - sine * velocity[:, 0]
    zero = numpy.zeros_like(left)
    command = numpy.stack((forward, left, velocity[:, 2], zero, zero, velocity[:, 3]), axis=-1)
    pitch = 0.02 * gusts[:, 4] + 0.1 * numpy.gradient(forward, times)
    roll = 0.02 * gusts[:, 0] - 0.1 * numpy.gradient(left, times)
    return position, yaw, pitch, roll, command


def _coloured(count: int, chance, memory: int):
    """Unit variance, correlated over some samples."""
    decay = numpy.exp(-1 / memory)
    result = numpy.empty(count)
    value = 0.0
    for k in range(count):
        value = decay * value + numpy.sqrt(1 - decay * decay) * chance.normal()
        result[k] = value
    return numpy.convolve(result, numpy.ones(9) / 9, mode="same")


def _rotation(roll: float, pitch: float, yaw: float):
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (numpy.cos, numpy.sin))
    return numpy.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                        [-sp, cp * sr, cp * cr]])


def _pose_row(time: float, position, rotation) -> list:
    r = rotation
    # Four times the outer product of the quaternion with itself; its longest column loses no digits.
    outer = numpy.array([
        [1 + r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
        [r[0, 1] + r[1, 0], 1 - r[0, 0] + r[1, 1] - r[2, 2], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
        [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 1 - r[0, 0] - r[1, 1] + r[2, 2], r[1, 0] - r[0, 1]],
        [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], 1 + r[0, 0] + r[1, 1] + r[2, 2]]])
    column = outer[:, numpy.argmax(numpy.diag(outer))]
    return [f"{START + time:.9f}", *position, *(column / numpy.linalg.norm(column)),
            numpy.arctan2(r[2, 1], r[2, 2]), numpy.arcsin(-r[2, 0]), numpy.arctan2(r[1, 0], r[0, 0])]


def _write_poses(data: Path, times, position, rotations, chance) -> None:
    correlations = [f"{a}_{b}_correlation" for k, a in enumerate(AXES) for b in AXES[k + 1:]]
    poses, states = [], []
    noise = numpy.stack([_coloured(len(times), chance, 15) for _ in range(6)], axis=-1)
    along = 0.002 + 0.001 * numpy.abs(numpy.sin(0.2 * times)) + 0.004 * (times % 13 > 10)
    for k, time in enumerate(times):
        if time < 0.2 or _lost(time):
            states.append((f"{START + time:.9f}", "lost" if time > 1 else "not started", 0, "no edges"))
            continue
        deviation = numpy.array([0.0015, along[k], 0.0012, 0.0007, 0.0005, 0.0006])
        error = noise[k] * deviation
        turn = _rotation(*error[3:])
        poses.append(_pose_row(time, position[k] + error[:3], turn @ rotations[k])
                     + [*deviation] + [0.3, *[0] * 14])
        states.append((f"{START + time:.9f}", "tracking", 0.9, ""))
    write_csv(data / "pose.csv", POSE + DEVIATIONS + correlations, poses)
    write_csv(data / "state.csv", ["stamp", "status", "quality", "reason"], states)


def _write_offsets(data: Path, times, chance) -> None:
    rows = []
    for name, begin in (("P1", 0.0), ("P2", 0.05), ("P3", 0.15), ("P4", 0.20), ("P5", 0.0)):
        noise = _coloured(len(times), chance, 60)
        for k, time in enumerate(times):
            deviation = 0.0 if begin == 0 else 0.03 * numpy.exp(-3 * time) + 0.0015
            settled = 0.0 if begin == 0 else (begin * numpy.exp(-4 * time) + deviation * noise[k])
            rows.append((time, name, TRUE_OFFSETS[name] + settled, deviation, int(begin != 0 and not _lost(time))))
    rows.sort(key=lambda row: row[0])
    write_csv(data / "offsets.csv", ["stamp", "pipe", "offset", "standard_deviation", "observed"],
              [(f"{START + row[0]:.9f}", *row[1:]) for row in rows])


def _write_images(data: Path, times, position, rotations, camera: dict, options: Options) -> None:
    (data / "images").mkdir()
    rows = []
    for number, time in enumerate(numpy.arange(0.2, options.seconds, options.image_period)):
        k = int(round(time * options.rate))
        pixels = render(position[k], rotations[k], camera)
        name = f"images/{number:06}.pgm"
        header = f"P5\n{camera['width']} {camera['height']}\n255\n".encode()
        (data / name).write_bytes(header + pixels.tobytes())
        rows.append((f"{START + times[k]:.9f}", name))
    write_csv(data / "images.csv", ["stamp", "file"], rows)


def render(position, rotation, camera: dict):
    """Shaded pipes and beams on mottled ground, where the rack file has them; shares no code with what is
    tested."""
    v, u = numpy.mgrid[0:camera["height"], 0:camera["width"]].astype(float)
    x, y = (u - camera["cu"]) / camera["f"], (v - camera["cv"]) / camera["f"]
    radius = numpy.hypot(x, y)
    ideal = radius.copy()
    for _ in range(20):
        ideal = radius / (1 + camera["k1"] * ideal ** 2)
    scale = numpy.where(radius > 0, ideal / numpy.maximum(radius, 1e-12), 1)
    rays = numpy.stack((x * scale, y * scale, numpy.ones_like(x)), axis=-1) @ rotation.T
    depth = -position[2] / rays[..., 2] - 0.2 / rays[..., 2]
    ground = position + depth[..., None] * rays
    grey = 70 + 12 * numpy.sin(9 * ground[..., 0]) * numpy.sin(7 * ground[..., 1])
    light = numpy.array([0.3, -0.2, 0.93])
    for low, high in BEAMS:
        with numpy.errstate(divide="ignore"):
            first, second = (numpy.array(low) - position) / rays, (numpy.array(high) - position) / rays
        entry = numpy.minimum(first, second).max(axis=-1)
        hit = (entry < numpy.maximum(first, second).min(axis=-1)) & (entry < depth)
        top = position[2] + entry * rays[..., 2] > high[2] - 1e-6
        grey = numpy.where(hit, numpy.where(top, 125, 95), grey)
        depth = numpy.where(hit, entry, depth)
    for number, (start, direction, length, first_radius, last_radius) in enumerate(PIPES):
        d = numpy.array(direction, dtype=float)
        slope = (last_radius - first_radius) / length
        w = position - numpy.array(start)
        ray_along = rays @ d
        across_ray = rays - ray_along[..., None] * d
        across_eye = w - (w @ d) * d
        eye_radius = first_radius + slope * (w @ d)
        a = (across_ray ** 2).sum(axis=-1) - (slope * ray_along) ** 2
        b = across_ray @ across_eye - slope * ray_along * eye_radius
        root = b * b - a * (across_eye @ across_eye - eye_radius ** 2)
        t = (-b - numpy.sqrt(numpy.maximum(root, 0))) / a
        along = w @ d + t * ray_along
        hit = (root > 0) & (along > 0) & (along < length) & (t > 0) & (t < depth)
        normal = across_eye + t[..., None] * across_ray
        normal /= numpy.maximum(numpy.linalg.norm(normal, axis=-1, keepdims=True), 1e-9)
        shade = 60 + 130 * numpy.clip(normal @ light, 0, 1) + 8 * numpy.sin(23 * along + number)
        grey = numpy.where(hit, shade, grey)
        depth = numpy.where(hit, t, depth)
    chance = numpy.random.default_rng(int(1e6 * abs(position[0])))
    return numpy.clip(grey + chance.normal(0, 2, grey.shape), 0, 255).astype(numpy.uint8)


def reproduction(path: Path) -> Path:
    """As `pipescout reproduce rack --json` writes it."""
    rows = []
    for samples in (50, 20):
        study = f"Table I: quantised pixels, 2 px of noise, {samples} samples an edge, each frame by itself"
        for pipes in (2, 3, 4, 5):
            for points in (10, 20, 30, 40, 50):
                position = 0.04 / numpy.sqrt(points * pipes / 20 + samples / 20)
                rows.append({"study": study, "pipes": pipes, "points": points, "position_m": position,
                             "position_m_sd": 0.1 * position, "paper_position_m": 0.15 - 0.001 * points,
                             "position_bound_rms_m": 1.1 * position, "orientation_deg": 10 * position,
                             "orientation_deg_sd": position, "paper_orientation_deg": 2 - 0.025 * points,
                             "orientation_bound_rms_deg": 11 * position, "ratio_to_bound": 1.05,
                             "frames": 1000, "frames_without_points": 3})
        rows.append({"figure": "table1_cells_half_of_paper", "study": study + ": cells", "value": 20})
    path.write_text(json.dumps({"figures": {}, "rows": rows, "seeds": [1, 2]}))
    return path
