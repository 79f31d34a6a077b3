# SPDX-License-Identifier: Apache-2.0
import unittest

import numpy
from pipescout_plots.support_graph import Support, Timeline


class Agreement(unittest.TestCase):
    def test_a_pair_agrees_wholly_when_both_support_each_other(self):
        rows = dict(Support(["1>2 2>1 2>3", "3>1", ""], 3).rows())
        self.assertEqual({label: row.tolist() for label, row in rows.items()},
                         {"1–2": [1, 0, 0], "1–3": [0, 0.5, 0], "2–3": [0.5, 0, 0]})

    def test_of_many_it_is_the_share_of_the_others(self):
        rows = dict(Support(["2>1 3>1 1>8 12>1"], 8).rows())
        self.assertAlmostEqual(rows["1"][0], 2 / 7)
        self.assertAlmostEqual(rows["8"][0], 1 / 7)
        self.assertEqual(rows["2"][0], 0)


class Times(unittest.TestCase):
    def test_the_mean_goes_by_time_and_leaves_silence_out(self):
        timeline = Timeline(numpy.array([5.0, 6, 7, 107, 108]))
        values = numpy.array([1.0, 0, 1, 0, 0])
        mean = timeline.mean(values, numpy.array([0.0, 2, 50, 101.5, 103, 200]))
        # The third row counts for ten usual steps, 2 s to 12 s.
        numpy.testing.assert_allclose(mean, [0.5, 1, 0, 0, 0])

    def test_short_stretches_are_widened(self):
        timeline = Timeline(numpy.arange(4000.0))
        rows = numpy.zeros(4000, dtype=bool)
        rows[2000] = True
        ((_, width),) = timeline.bars(rows)
        self.assertAlmostEqual(width, timeline.shown / 400)
