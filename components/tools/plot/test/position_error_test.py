# SPDX-License-Identifier: Apache-2.0
import tempfile
import unittest
from pathlib import Path

import missions
import numpy
from pipescout_plots.csv_table import read_table
from pipescout_plots.position_error import linear_part, position_error

COLUMNS = ["stamp", "odometer_distance", "known", "joint", "distance_into_joint", "chainage"]


class PositionError(unittest.TestCase):
    def errors(self, positions, truth):
        with tempfile.TemporaryDirectory() as folder:
            tables = []
            for name, rows in (("positions", positions), ("truth", truth)):
                path = Path(folder) / f"{name}.csv"
                missions.write_csv(path, missions.PLACE, [missions.place(*row[:4], **row[4]) for row in rows])
                tables.append(read_table(path, COLUMNS, ["orientation"]))
            return position_error(*tables)

    def test_in_the_joint_it_is_the_difference_of_the_distances_into_it(self):
        truth = [(0, 0, 4, 1, {}), (2, 2, 4, 3, {})]
        # The tally's chainage is 7 m off, which is no error of the position in the joint.
        errors = self.errors([(1, 5, 4, 2.25, {"chainage": 57.25}), (3, 5, 4, 2, {})], truth)
        self.assertAlmostEqual(errors[0], 0.25)
        self.assertTrue(numpy.isnan(errors[1]), "there is no truth after its end")

    def test_just_behind_a_weld_it_counts_from_the_weld_of_the_joint_before(self):
        truth = [(0, 0, 4, 11, {}), (2, 2, 5, 1, {}), (4, 4, 5, 3, {})]
        errors = self.errors([(2, 2, 4, 12.9, {"chainage": 99})], truth)
        self.assertAlmostEqual(errors[0], -0.1)

    def test_in_a_pipe_passed_backwards(self):
        back = {"orientation": "backward"}
        truth = [(0, 0, 4, 3, back), (2, 2, 4, 1, back)]
        self.assertAlmostEqual(self.errors([(1, 1, 4, 2.25, back)], truth)[0], 0.25)

    def test_in_a_wrong_joint_it_is_the_difference_of_the_chainages(self):
        truth = [(0, 0, 4, 1, {}), (2, 2, 4, 3, {})]
        self.assertAlmostEqual(self.errors([(1, 1, 7, 2, {})], truth)[0], 3 * missions.JOINT)

    def test_what_is_not_known_has_no_error(self):
        truth = [(0, 0, 4, 1, {}), (2, 2, 4, 3, {})]
        self.assertTrue(numpy.isnan(self.errors([(1, 1, 4, 2, {"known": 0})], truth)[0]))


class Axis(unittest.TestCase):
    def test_a_few_large_errors_leave_the_usual_ones_readable(self):
        values = numpy.concatenate((numpy.full(350, 0.03), numpy.full(10, 0.6)))
        self.assertEqual(linear_part(values, 0.78), 0.1)

    def test_errors_of_one_size_need_no_logarithm(self):
        self.assertIsNone(linear_part(numpy.linspace(0.01, 0.3, 100), 0.39))
        self.assertIsNone(linear_part(numpy.full(5, numpy.nan), 1.0))
        self.assertIsNone(linear_part(numpy.zeros(5), 1e-3))
