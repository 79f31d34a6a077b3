# SPDX-License-Identifier: Apache-2.0
"""The whole command on a small mission of a robot that is navigated."""

import contextlib
import io
import json
import math
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import lists
import numpy
from missions import START, write_csv
from pictures import paths
from PIL import Image
from pipescout_plots.command_line import main


def mission(folder: Path) -> Path:
    """Along a road of 20 m, with a stop in its middle."""
    data = folder / "navigation"
    stamps = [START + 0.05 * k for k in range(800)]
    write_csv(data / "plan.csv", ["stamp", "plan", "x", "y", "yaw"],
              [[f"{START:.9f}", 1, 0.2 * k, 0, 0] for k in range(100)])
    states, way = [], []
    x = 0.0
    for k, stamp in enumerate(stamps):
        stands = 300 <= k < 400
        speed = 0.0 if stands else 0.5
        x += 0.05 * speed
        states.append([f"{stamp:.9f}", "driving", "waiting" if stands else "driving",
                       "moving obstacle" if stands else "speed limit", "motion blur", "", speed, 0, x, 20 - x,
                       0.01 * math.sin(k), 0, 0, 8, 0, 0])
        way.append([f"{stamp:.9f}", x, 0.01 * math.sin(k), 0, speed])
    write_csv(data / "state.csv", ["stamp", "state", "drive", "reason", "inspection", "failure", "speed",
                                   "curvature", "travelled", "remaining", "lateral_error", "heading_error",
                                   "offset", "free_distance", "replans", "passed"], states)
    for name in ("localisation.csv", "truth.csv"):
        write_csv(data / name, ["stamp", "x", "y", "yaw", "speed"], way)
    write_csv(data / "obstacles.csv", ["stamp", "x", "y", "times"],
              [[f"{START:.9f}", 12, 2, 9], [f"{START:.9f}", 5, 2, 1], [f"{START:.9f}", 10, 4.9, 9]])
    write_csv(data / "coverage.csv", ["stamp", "row", "from", "to", "sharp", "blur", "temperature"],
              [[f"{START:.9f}", 0, k, k + 1, int(k != 7), 0.5, ""] for k in range(20)])
    place = folder / "map"
    place.mkdir()
    pixels = numpy.full((100, 240), 255, numpy.uint8)
    pixels[:2] = 0
    Image.fromarray(pixels).save(place / "plant.pgm")
    (place / "plant.yaml").write_text("image: plant.pgm\nresolution: 0.1\norigin: [-2.0, -5.0, 0.0]\n")
    (place / "plant.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": {"id": 0, "startid": 0, "endid": 1, "metadata": {"pipe_side": "left"}},
         "geometry": {"type": "LineString", "coordinates": [[0, 0], [20, 0]]}}]}))
    return folder


def run(*arguments) -> tuple[int, str, str]:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(argument) for argument in arguments])
    return code, out.getvalue(), err.getvalue()


class NavigationTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def texts(self, name):
        root = ElementTree.parse(self.folder / "pictures" / f"{name}.svg").getroot()
        return {text for element in root.iter() for text in [(element.text or "").strip()] if text}

    def test_draws_plant_and_timeline(self):
        code, out, err = run("navigation", mission(self.folder))
        self.assertEqual((code, err), (0, ""))
        self.assertEqual({path.stem for path in paths(out)}, {"plant", "navigation"})
        self.assertLessEqual({"route graph", "planned", "driven", "obstacle, not in map", "seen less than 3 times",
                              "pipe seen sharp", "pipe not sharp",
                              "waited"}, self.texts("plant"))
        self.assertLessEqual({"moving obstacle", "motion blur"}, self.texts("navigation"))

    def test_without_a_map(self):
        folder = mission(self.folder)
        for file in (folder / "map").iterdir():
            file.unlink()
        code, _, err = run("navigation", folder)
        self.assertEqual((code, err), (0, ""))

    def test_leaks_are_drawn_with_their_numbers(self):
        folder = mission(self.folder)
        lists.seen_leaks(folder / "leaks")
        code, _, err = run("navigation", folder)
        self.assertEqual(code, 0)
        self.assertLessEqual({"leak found", "1"}, self.texts("plant"))
        self.assertIn("leaks without a known place are not in the picture from above: 2", err)

    def test_a_broken_map_is_named(self):
        folder = mission(self.folder)
        (folder / "map/plant.pgm").unlink()
        code, out, err = run("navigation", folder)
        self.assertEqual(code, 1)
        self.assertIn("plant.yaml", err)
        self.assertIn("navigation.svg", out)


if __name__ == "__main__":
    unittest.main()
