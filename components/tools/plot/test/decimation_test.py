# SPDX-License-Identifier: Apache-2.0
import unittest

import numpy
from pipescout_plots.decimation import decimate, envelope, one_way_pieces, stretches


class Decimation(unittest.TestCase):
    def test_keeps_every_extreme(self):
        x = numpy.arange(100000.0)
        y = numpy.sin(x / 777)
        y[[123, 54321, 99999]] = [9, -8, 7]
        few_x, few_y = decimate(x, y, 100)
        self.assertLessEqual(len(few_x), 400)
        for spike in (123, 54321, 99999):
            self.assertEqual(few_y[numpy.flatnonzero(few_x == spike)[0]], y[spike])
        self.assertTrue((numpy.diff(few_x) > 0).all())
        for start in range(0, 100000, 1000):
            inside = (few_x >= start) & (few_x < start + 1000)
            part = y[start:start + 1000]
            self.assertEqual(few_y[inside].min(), part.min())
            self.assertEqual(few_y[inside].max(), part.max())

    def test_leaves_few_samples_alone(self):
        x = numpy.arange(4.0)
        self.assertIs(decimate(x, x, 1)[0], x)

    def test_keeps_gaps_and_what_is_beside_them(self):
        x = numpy.arange(1000.0)
        y = numpy.ones(1000)
        y[400:600] = numpy.nan
        y[399] = 5
        few_x, few_y = decimate(x, y, 20)
        self.assertTrue(numpy.isnan(few_y[(few_x > 410) & (few_x < 590)]).all())
        self.assertEqual(numpy.nanmax(few_y), 5)

    def test_a_band_covers_all_of_its_samples(self):
        x = numpy.arange(1003.0)
        high = numpy.cos(x / 9)
        few_x, low, top = envelope(x, -high, high, 30)
        self.assertTrue((numpy.interp(x, few_x, top) >= numpy.minimum(high, top.max()) - 0.3).all())
        self.assertEqual(top.max(), high.max())
        self.assertEqual(low.min(), (-high).min())

    def test_splits_where_x_turns_back(self):
        x = numpy.array([0.0, 1, 2, 2, 1, 1, 3])
        self.assertEqual([x[piece].tolist() for piece in one_way_pieces(x)],
                         [[0, 1, 2, 2], [2, 1, 1], [1, 3]])

    def test_widens_what_is_too_short_to_see_and_joins_what_meets(self):
        starts, ends = numpy.array([0.0, 10, 10.5, 50]), numpy.array([5.0, 10.5, 11, 50.1])
        self.assertEqual(stretches(starts, ends, 1.0),
                         [(0, 5), (9.75, 11.25), (50.05 - 0.5, 50.05 + 0.5)])
