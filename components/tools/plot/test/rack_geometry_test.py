# SPDX-License-Identifier: Apache-2.0
"""Rotations, velocities, errors, contours and rack files of the pictures of flights."""

import tempfile
import unittest
from pathlib import Path

import flights
import numpy
from pipescout_plots.csv_table import BadData
from pipescout_plots.ellipses import magnification
from pipescout_plots.rack import rotations
from pipescout_plots.rack.camera import Camera
from pipescout_plots.rack.contours import contour_lines, image_lines, support_edges
from pipescout_plots.rack.errors import pose_errors
from pipescout_plots.rack.flight import velocities
from pipescout_plots.rack.flight_data import Poses
from pipescout_plots.rack.offsets import summed_distances
from pipescout_plots.rack.rack_file import Rack, Section, Support, parse_rack


def quaternion(axis, angle):
    return numpy.append(numpy.sin(angle / 2) * numpy.array(axis, dtype=float), numpy.cos(angle / 2))


class Rotations(unittest.TestCase):
    def test_angles_round_trip(self):
        for angles in ((0.1, -0.2, 0.3), (3.0, 1.2, -2.0), (0, 0, 0)):
            rotation = rotations.from_roll_pitch_yaw(*angles)
            numpy.testing.assert_allclose(rotations.yaw_pitch_roll(rotation), angles[::-1], atol=1e-12)

    def test_logarithm(self):
        axis = numpy.array([2, -1, 2]) / 3
        for angle in (0, 1e-12, 1e-3, 1.0, 3.0):
            rotation = rotations.from_quaternions(quaternion(axis, angle))
            numpy.testing.assert_allclose(rotations.logarithm(rotation), angle * axis, atol=1e-12)

    def test_interpolation_does_not_mind_the_sign_of_a_quaternion(self):
        q = numpy.array([quaternion([0, 0, 1], 0.2), -quaternion([0, 0, 1], 0.3)])
        between = rotations.interpolate(numpy.array([0.0, 1.0]), q, numpy.array([0.5, 2.0]))
        self.assertAlmostEqual(rotations.yaw_pitch_roll(between)[0, 0], 0.25, places=6)
        self.assertTrue(numpy.isnan(between[1]).all())

    def test_a_camera_that_looks_down_has_a_level_vehicle(self):
        numpy.testing.assert_allclose(
            rotations.yaw_pitch_roll(rotations.DOWNWARD_CAMERA @ rotations.DOWNWARD_CAMERA.T), 0)
        self.assertEqual(numpy.linalg.det(rotations.DOWNWARD_CAMERA), 1)


class Motion(unittest.TestCase):
    def test_velocities_are_in_the_level_frame(self):
        times = 0.04 * numpy.arange(50)
        yaw = numpy.pi / 2 + 0.3 * times
        poses = Poses(times, numpy.stack((0 * times, 0.4 * times, 3 + 0 * times), axis=-1),
                      numpy.array([quaternion([0, 0, 1], angle) for angle in yaw]))
        stamps, linear, angular = velocities(poses, numpy.eye(3))
        turned = 0.3 * stamps
        numpy.testing.assert_allclose(linear, numpy.stack(
            (0.4 * numpy.cos(turned), -0.4 * numpy.sin(turned), 0 * turned), axis=-1), atol=1e-6)
        numpy.testing.assert_allclose(angular, [[0, 0, 0.3]] * len(stamps), atol=1e-5)

    def test_errors_are_about_the_axes_of_the_rack(self):
        times = numpy.array([0.0, 0.1])
        truth = Poses(times, numpy.zeros((2, 3)), numpy.array([[1, 0, 0, 0], [1, 0, 0, 0]], dtype=float))
        turned = numpy.array([[1.0, 0, 0, 0], [1.0, 0, 0, 0]])
        # Half a turn about x, then 0.01 about z of the rack.
        turned[1] = [numpy.cos(0.005), numpy.sin(0.005), 0, 0]
        error = pose_errors(Poses(times, numpy.array([[0, 0, 0], [0.001, 0, 0]]), turned), truth)
        numpy.testing.assert_allclose(error[1], [0.001, 0, 0, 0, 0, 0.01], atol=1e-9)

    def test_nothing_bridges_a_gap(self):
        poses = Poses(numpy.array([0.0, 0.1, 5.0]), numpy.zeros((3, 3)),
                      numpy.array([[0, 0, 0, 1.0]] * 3))
        known = ~numpy.isnan(poses.positions_at(numpy.array([0.05, 0.1, 2.0, 5.0]))[:, 0])
        self.assertEqual(known.tolist(), [True, True, False, True])

    def test_ellipses_are_magnified_by_round_numbers(self):
        self.assertEqual(magnification(numpy.array([[0.001, 0.002]]), 0.2), 50)
        self.assertEqual(magnification(numpy.array([[5.0, 2.0]]), 0.2), 1)


class Contours(unittest.TestCase):
    eye = numpy.array([1.0, 4.0, 3.0])

    def section(self, last=0.2):
        return Section(numpy.array([0.2, 0.0, 0.2]), numpy.array([0.0, 1.0, 0.0]), 10.0, 0.2, last, 0)

    def test_rays_touch_the_surface(self):
        for section in (self.section(), self.section(last=0.4)):
            slope = (section.radius_end - section.radius_start) / section.length
            for start, end in contour_lines(section, self.eye):
                for point in (start, 0.3 * start + 0.7 * end, end):
                    across = point - section.start
                    along = float(across @ section.direction)
                    across -= along * section.direction
                    radius = section.radius_start + slope * along
                    self.assertAlmostEqual(float(numpy.linalg.norm(across)), radius)
                    normal = across / radius - slope * section.direction
                    self.assertAlmostEqual(float(normal @ (point - self.eye)), 0)

    def test_from_within_there_is_none(self):
        self.assertEqual(contour_lines(self.section(), numpy.array([0.25, 4, 0.2])), [])
        self.assertEqual(contour_lines(self.section(), numpy.array([0.2, 4, 0.2])), [])

    def test_a_beam_from_above_shows_its_upper_face(self):
        beam = Support("B", numpy.array([0.0, 0.0, 0.0]), numpy.array([2.0, 0.2, 0.2]))
        edges = support_edges(beam, numpy.array([1.0, 0.1, 3.0]))
        self.assertEqual(len(edges), 4)
        self.assertTrue(all(start[2] == end[2] == 0.2 for start, end in edges))
        self.assertEqual(len(support_edges(beam, numpy.array([1.0, 5.0, 3.0]))), 7)

    def test_lenses_project_as_ros_defines_them(self):
        matrix = numpy.array([[200.0, 0, 100], [0, 210.0, 80], [0, 0, 1]])
        fisheye = Camera(200, 160, matrix, numpy.array([0.1, 0.02, 0, 0, 0, 0, 0, 0]), True)
        theta = 0.9
        angle = theta * (1 + 0.1 * theta ** 2 + 0.02 * theta ** 4)
        points = numpy.array([[0, 0, 2.0], [0.6 * numpy.tan(theta), 0.8 * numpy.tan(theta), 1], [9, 0, 1]])
        pixels = fisheye.project(points)
        self.assertTrue(numpy.allclose(pixels[:2], [[100, 80], [100 + 200 * 0.6 * angle, 80 + 210 * 0.8 * angle]]))
        self.assertTrue(numpy.isnan(pixels[2]).all())
        wide = Camera(200, 160, matrix, numpy.array([0.3, 0, 0, 0, 0, 0.5, 0, 0]))
        factor = (1 + 0.3 * 0.25) / (1 + 0.5 * 0.25)
        self.assertTrue(numpy.allclose(wide.project(numpy.array([[0.5, 0, 1.0]])), [[100 + 100 * factor, 80]]))

    def test_lines_lie_on_the_edges_of_a_rendered_image(self):
        """The image is of a ray caster that shares no code with the lines. Pipes only: the edges of beams lie
        some pixels beside stronger ones."""
        for k1 in (0.0, -0.15):
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "rack.yaml"
                path.write_text(flights.RACK)
                rack = parse_rack(path)
            width, height, f = 720, 480, 630.0
            camera = Camera(width, height, numpy.array([[f, 0, 360], [0, f, 240], [0, 0, 1.0]]),
                            numpy.array([k1, 0, 0, 0, 0, 0, 0, 0]))
            position = numpy.array([1.3, 5.4, 2.6])
            rotation = rotations.from_roll_pitch_yaw(0.05, -0.04, 1.5) @ rotations.DOWNWARD_CAMERA
            pixels = flights.render(position, rotation, {"width": width, "height": height, "f": f,
                                                         "cu": 360, "cv": 240, "k1": k1}).astype(float)
            distances = []
            for line in image_lines(Rack(rack.pipes), {}, camera, position, rotation):
                for k in range(2, len(line.pixels) - 2):
                    here, step = line.pixels[k], line.pixels[k + 1] - line.pixels[k - 1]
                    if line.hidden[k - 2:k + 3].any() or not numpy.isfinite([*here, *step]).all():
                        continue
                    normal = numpy.array([-step[1], step[0]]) / numpy.linalg.norm(step)
                    profile = [_grey(pixels, here + s * normal) for s in numpy.arange(-5, 6)]
                    if not numpy.isfinite(profile).all():
                        continue
                    change = numpy.abs(numpy.diff(profile))
                    if change.max() > 30:
                        distances.append(numpy.argmax(change) - 4.5)
            self.assertGreater(len(distances), 150)
            self.assertLess(numpy.median(numpy.abs(distances)), 0.6)
            self.assertLess(numpy.quantile(numpy.abs(distances), 0.95), 1.6)


def _grey(pixels, place):
    u, v = numpy.round(place).astype(int)
    height, width = pixels.shape
    return pixels[v, u] if 0 <= u < width and 0 <= v < height else numpy.nan


class RackFile(unittest.TestCase):
    def parse(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "rack.yaml"
            path.write_text(text)
            return parse_rack(path)

    def test_a_row_begins_at_the_left_edge(self):
        rack = self.parse(flights.RACK)
        self.assertEqual([pipe.name for pipe in rack.pipes], ["P1", "P2", "P3", "P4", "P5"])
        numpy.testing.assert_allclose([pipe.start[0] for pipe in rack.pipes[:4]], [0.2, 0.65, 1.1, 1.58])
        numpy.testing.assert_allclose([pipe.start[2] for pipe in rack.pipes[:4]], [0.2, 0.15, 0.2, 0.18])
        self.assertEqual(len(rack.sections({})), 7)
        moved = rack.sections({"P2": 0.05})[3]
        self.assertAlmostEqual(moved.start[0], 0.70)
        distances = summed_distances(rack)
        numpy.testing.assert_allclose([distances[name] for name in ("P2", "P3", "P4")], [0.1, 0.2, 0.3])

    def test_bad_files_are_named_with_their_line(self):
        good = "row:\n  - {name: a, radius: 0.1, length: 3}\n"
        for text, words in (("", "not a rack"), ("[]", "not a rack"), ("supports: []", "no pipes"),
                            ("row: 3", "line 1: 'row' is not a list"), ("row: [3]", "line 1: 'row'"),
                            ("row:\n  - {name: a, radius: x, length: 3}", "line 2: 'radius' is not a finite"),
                            ("row:\n  - {name: a, radius: .nan, length: 3}", "line 2: 'radius'"),
                            ("row:\n  - {radius: 0.1, length: 3}", "line 2: 'name' is not text"),
                            ("row:\n  - {name: a, radius: 0.1, length: -3}", "line 2: 'length' leads"),
                            ("row:\n  - name: a\n    radii: [{along: 0, radius: 1}]", "'radii' leads"),
                            (good + "pipes:\n  - {name: b, start: [0, 1]}", "line 4: 'direction'"),
                            (good + "pipes:\n  - {name: b, start: [0, 0, 1], direction: [0, 0, 0]}",
                             "'direction' is zero"),
                            (good + "supports:\n  - {name: s}", "line 4: 'lowest_corner'"),
                            ("row: [", "rack.yaml: ")):
            with self.assertRaises(BadData) as caught:
                self.parse(text)
            self.assertIn(words, str(caught.exception))
            self.assertIn("rack.yaml", str(caught.exception))


if __name__ == "__main__":
    unittest.main()
