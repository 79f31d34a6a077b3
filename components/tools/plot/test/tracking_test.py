# SPDX-License-Identifier: Apache-2.0
"""The whole command on a small recording of a track and an arm."""

import contextlib
import io
import math
import shutil
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy
from missions import START, write_csv
from PIL import Image
from pictures import paths, unreadable
from pipescout_plots import style
from pipescout_plots.command_line import main
from pipescout_plots.recording import Recording
from pipescout_plots.tracking import animation, overlay, track_data

PICTURES = {"tracking_errors", "particles", "arm", "tracking"}
WIDTH, HEIGHT = 80, 60
COLUMNS = ("u", "v", "length", "angle")
ESTIMATES = ("best_particle", "robust_mean", "weighted_mean")


def section(time):
    return WIDTH / 2, HEIGHT / 2 + 8 * math.sin(time), WIDTH, 0.05 * math.cos(time)


def picture(file: Path, time):
    pixels = numpy.zeros((HEIGHT, WIDTH), numpy.uint8)
    u, v, _, angle = section(time)
    for x in range(WIDTH):
        y = round(v + (x - u) * math.tan(angle))
        pixels[max(0, y - 2):y + 3, x] = 220
    file.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(file)


def recording(mission: Path, seconds=8.0) -> Path:
    """The pipe sways; before 1 s it is not tracked yet, and the estimate is 1 px low."""
    data = mission / "tracking"
    stamps = [START + 0.04 * k for k in range(round(25 * seconds))]
    track, truth = [], []
    for stamp in stamps:
        time = stamp - START
        true = section(time)
        truth.append([f"{stamp:.9f}", 1, 1, *true, 2.5, 1, 10, WIDTH, HEIGHT])
        told = time >= 1
        mine = (true[0], true[1] + 1, true[2], true[3] + math.pi) if told else ("",) * 4
        track.append([f"{stamp:.9f}", "", "locked" if told else "detecting", int(told), 0.9 * told, 0, *mine,
                      *([0.5] * 4), 2.5, 1, 10, *(mine * 3), 500, 2])
    write_csv(data / "track.csv",
              ["stamp", "fault", "state", "track", "confidence", "since_seen", *COLUMNS,
               *(f"{name}_standard_deviation" for name in COLUMNS), "half_width", "whole_width", "range",
               *(f"{estimate}.{name}" for estimate in ESTIMATES for name in COLUMNS), "effective_samples",
               "regions"], track)
    write_csv(data / "truth.csv", ["stamp", "beside_pipe", "in_view", *COLUMNS, "half_width", "whole_width",
                                   "range", "width", "height"], truth)
    kept = stamps[::25]
    write_csv(data / "pictures.csv", ["stamp", "file"],
              [(f"{stamp:.9f}", f"pictures/{k:06}.png") for k, stamp in enumerate(kept)])
    particles = []
    for k, stamp in enumerate(kept):
        picture(data / f"pictures/{k:06}.png", stamp - START)
        u, v, length, angle = section(stamp - START)
        particles += [(f"{stamp:.9f}", u + i % 5 - 2, v + i // 5 - 2, length, angle, 0.04) for i in range(25)]
    write_csv(data / "particles.csv", ["stamp", *COLUMNS, "weight"], particles)
    write_csv(data / "arm.csv", ["stamp", "state"],
              [(f"{stamp:.9f}", "tracking" if stamp - START >= 1 else "holding") for stamp in stamps])
    write_csv(data / "joints.csv", ["stamp", "joint", "position", "velocity"],
              [(f"{stamp:.9f}", f"{joint}_joint", 0.1 * math.sin(stamp), "")
               for stamp in stamps for joint in ("shoulder_lift", "elbow")])
    return data


class Tracking(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.made = Path(folder.name) / "mission"
        recording(cls.made)

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.mission = Path(self._folder.name) / "mission"
        shutil.copytree(self.made, self.mission)
        self.data = self.mission / "tracking"

    def plot(self, *arguments, code=0):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            self.assertEqual(main(["tracking", *map(str, arguments)]), code, err.getvalue())
        return {Path(path).stem: Path(path) for path in paths(out.getvalue())}, err.getvalue()

    def test_all_texts_of_a_frame_of_the_animation_can_be_read(self):
        style.begin()
        data = recording(self.mission / "frames")
        mine = Recording(self.mission, data)
        pictures = overlay.read_pictures(mine)
        joints = mine.table("joints.csv", "", ["stamp", "position"], ["joint"])
        figure = animation.draw_frame(mine, pictures, joints, 1)
        self.assertEqual(unreadable(figure), [])
        self.assertEqual([axes.get_xlabel() for axes in figure.get_axes()], ["", "time [s]"])
        self.assertEqual(len(figure.get_axes()[1].get_legend().get_texts()), 2)

    def test_a_mission_gets_its_pictures(self):
        files, err = self.plot(self.mission)
        self.assertEqual(set(files), PICTURES)
        self.assertEqual(err, "")
        for name, file in files.items():
            self.assertEqual(file.parent, self.mission / "pictures")
            if name != "tracking":
                text = "".join(ElementTree.parse(file).getroot().itertext())
                self.assertTrue(text.strip() or name == "particles", name)
        with Image.open(files["tracking"]) as animation:
            self.assertEqual(animation.n_frames, 8)

    def test_the_same_recording_gives_the_same_bytes(self):
        first, _ = self.plot(self.mission, "--out", self.mission / "first")
        second, _ = self.plot(self.mission, "--out", self.mission / "second")
        for name, file in first.items():
            self.assertEqual(file.read_bytes(), second[name].read_bytes(), name)

    def test_errors_are_those_of_pictures_in_which_the_pipe_is_tracked(self):
        style.begin()
        errors = track_data.read_errors(Recording(self.mission, self.data))
        self.assertEqual(len(errors.stamps), 175)
        for values in errors.of.values():
            numpy.testing.assert_allclose(values, numpy.tile([0, 1, 0, 0], (175, 1)), atol=1e-9)

    def test_without_a_truth_there_are_no_errors_and_without_an_arm_none_of_it(self):
        (self.data / "truth.csv").unlink()
        (self.data / "joints.csv").unlink()
        files, err = self.plot(self.mission)
        self.assertEqual(set(files), {"particles", "tracking"})
        self.assertIn("only a simulation knows", err)
        self.assertIn("there is no arm", err)

    def test_a_picture_that_is_none_is_an_error(self):
        for file in (self.data / "pictures").iterdir():
            file.write_text("no picture")
        files, err = self.plot(self.mission, code=1)
        self.assertEqual(set(files), {"tracking_errors", "arm"})
        self.assertIn(".png", err)

    def test_a_picture_may_not_lie_outside(self):
        path = self.data / "pictures.csv"
        path.write_text(path.read_text().replace("pictures/", "../../pictures/"))
        files, err = self.plot(self.mission)
        self.assertEqual(set(files), {"tracking_errors", "arm"})
        self.assertIn("outside", err)

    def test_a_folder_without_a_track_says_so(self):
        (self.data / "track.csv").unlink()
        _, err = self.plot(self.mission, code=1)
        self.assertIn("nothing that can be drawn in", err)


if __name__ == "__main__":
    unittest.main()
