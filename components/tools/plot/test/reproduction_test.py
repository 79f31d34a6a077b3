# SPDX-License-Identifier: Apache-2.0
import unittest

from pipescout_plots.reproduction import detector_curves


class Reproduction(unittest.TestCase):
    def test_finds_the_curves_of_the_detector(self):
        rows = [{"study": f"Weld detector at {decibels} dB, all", "measure": "welds found, %", "value": value,
                 "per_seed": [1, None]} for decibels, value in ((12, 99.0), (-3.5, 60), (15, None))]
        rows.append({"study": "Wheels", "measure": "welds found, %", "value": 1})
        curve = detector_curves(rows)["welds found, %"]
        self.assertEqual([point[:2] for point in curve], [(-3.5, 60), (12, 99)])

    def test_one_point_is_no_curve(self):
        self.assertEqual(detector_curves([{"study": "detector at 12 dB", "measure": "m", "value": 1}]), {})
