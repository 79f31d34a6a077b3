# SPDX-License-Identifier: Apache-2.0
"""Of every picture: all texts are inside of it, and none covers another."""

from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

import flights
import lists
import missions
import navigation_test
import runs
import tracking_test
from pictures import unreadable
from pipescout_plots import style
from pipescout_plots.contents import find
from pipescout_plots.recording import Animation, Missing
from pipescout_plots.subjects import KINDS


def make(folder: Path) -> None:
    """Data of each kind that is drawn."""
    missions.crawler(folder / "crawler")
    missions.readings(folder / "readings")
    missions.alignment(folder / "alignment.csv")
    lists.ledger(folder / "ledger.csv")
    lists.welds(folder / "welds_found.csv")
    flights.flight(folder / "flight", seconds=24.0, rate=10.0, width=180, image_period=4.0)
    lists.seen_leaks(folder / "flight/leaks")
    lists.camera_poses(folder / "camera_poses")
    runs.run(folder / "robot")
    lists.trajectory(folder / "trajectory")
    (folder / "patrol").mkdir()
    navigation_test.mission(folder / "patrol")
    lists.seen_leaks(folder / "patrol/leaks")
    lists.leaks(folder / "patrol/report")
    tracking_test.recording(folder / "patrol")
    lists.image_track(folder / "images")


class Layout(unittest.TestCase):
    def test_every_text_can_be_read(self):
        style.begin()
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            make(folder)
            contents = find(folder, KINDS)
            self.assertEqual(contents.strange, [])
            self.assertEqual({held.kind.what for held in contents.held}, {kind.what for kind in KINDS})
            for held in contents.held:
                for picture in held.kind.pictures:
                    if isinstance(picture, Animation):
                        continue
                    with self.subTest(held.kind.what, picture=picture.name):
                        try:
                            figure = picture.draw(held.recording)
                        except Missing:
                            continue
                        self.assertEqual(unreadable(figure), [])


if __name__ == "__main__":
    unittest.main()
