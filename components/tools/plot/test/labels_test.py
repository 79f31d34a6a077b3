# SPDX-License-Identifier: Apache-2.0
import unittest

from matplotlib.transforms import Bbox
from pipescout_plots import style
from pipescout_plots.labels import Label, place_labels


class Labels(unittest.TestCase):
    def test_cover_neither_each_other_nor_the_points(self):
        style.begin()
        figure = style.figure(3.0)
        axes = figure.subplots()
        points = [(x, y) for x in (1.0, 1.04, 1.08, 9.9) for y in (1.0, 1.05)]
        axes.plot(*zip(*points), "x", markersize=4)
        axes.set(xlim=(0, 10), ylim=(0, 10))
        place_labels(axes, [Label(x, y, f"{k}0", "black") for k, (x, y) in enumerate(points)])
        figure.draw_without_rendering()
        renderer = figure.canvas.get_renderer()
        texts = [text for text in axes.texts if text.get_text()]
        self.assertEqual(len(texts), len(points))
        boxes = [text.get_window_extent(renderer) for text in texts]
        panel = axes.get_window_extent(renderer)
        marks = axes.transData.transform(points)
        for k, box in enumerate(boxes):
            self.assertTrue(all(Bbox.intersection(box, other) is None for other in boxes[:k]), texts[k])
            self.assertFalse(any(box.contains(*mark) for mark in marks), texts[k])
            self.assertTrue(panel.contains(box.x0, box.y0) and panel.contains(box.x1, box.y1), texts[k])


if __name__ == "__main__":
    unittest.main()
