# SPDX-License-Identifier: Apache-2.0
import unittest

from pipescout_plots.reproduction import bend_errors, detector_curves


class Reproduction(unittest.TestCase):
    def test_finds_the_curves_of_the_detector(self):
        rows = [{"study": f"Weld detector at {decibels} dB, all", "measure": "welds found, %", "value": value,
                 "per_seed": [1, None]} for decibels, value in ((12, 99.0), (-3.5, 60), (15, None))]
        rows.append({"study": "Wheels", "measure": "welds found, %", "value": 1})
        curve = detector_curves(rows)["welds found, %"]
        self.assertEqual([point[:2] for point in curve], [(-3.5, 60), (12, 99)])

    def test_finds_the_rules_in_bends(self):
        rows = [{"study": "Bends, the rules compared", "measure": f"{rule}: error of a bend, {what}, m", "value": value}
                for rule, what, value in (("average", "95 %", 0.2), ("average", "worst", 0.3), ("ours", "95 %", None))]
        rows.append({"study": "Bends", "measure": "average: error of a bend, median, m", "value": 1})
        self.assertEqual(bend_errors(rows), {"average": {"95 %": 0.2, "worst": 0.3}})

    def test_one_point_is_no_curve(self):
        self.assertEqual(detector_curves([{"study": "detector at 12 dB", "measure": "m", "value": 1}]), {})
