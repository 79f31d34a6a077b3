# SPDX-License-Identifier: Apache-2.0
"""The whole command on small flights over a rack."""

import contextlib
import io
import re
import shutil
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import flights
import numpy
from PIL import Image
from pictures import paths
from pipescout_plots import style
from pipescout_plots.command_line import main
from pipescout_plots.csv_table import BadData
from pipescout_plots.rack import errors, offsets
from pipescout_plots.rack.flight_data import Poses, read_servo, read_true_offsets
from pipescout_plots.rack.overlay import read_images
from pipescout_plots.recording import Missing, Recording

PICTURES = {"flight", "pose_errors", "offsets", "overlay", "map", "animation"}
WITHOUT_RACK = {"flight", "pose_errors", "offsets", "map"}


def texts(file: Path) -> str:
    return "".join(ElementTree.parse(file).getroot().itertext())


class Rack(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.made = Path(folder.name) / "mission"
        flights.flight(cls.made, seconds=24.0, rate=10.0, width=180, image_period=4.0)

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.mission = Path(self._folder.name) / "mission"
        shutil.copytree(self.made, self.mission)
        self.data = self.mission / "rack"
        self._recordings: list[Recording] = []
        style.begin()

    def plot(self, *arguments, code=0):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            self.assertEqual(main(["rack", *map(str, arguments)]), code, err.getvalue())
        return {Path(path).stem: Path(path) for path in paths(out.getvalue())}, err.getvalue()

    def recording(self) -> Recording:
        self._recordings.append(Recording(self.mission, self.data))
        return self._recordings[-1]

    def errors_as_svg(self) -> str:
        path = self.mission / "errors.svg"
        style.write(errors.draw(self.recording()), path)
        return path.read_text()

    def notes(self) -> str:
        return "\n".join(note for recording in self._recordings for note in recording.notes)

    def replace(self, name: str, old: str, new: str):
        path = self.data / name
        content = path.read_text()
        self.assertIn(old, content)
        path.write_text(content.replace(old, new, 1))

    def test_a_flight_gets_its_pictures(self):
        files, err = self.plot(self.mission)
        self.assertEqual(set(files), PICTURES)
        self.assertEqual(err, "")
        for name, file in files.items():
            self.assertEqual(file.parent, self.mission / "pictures")
            self.assertLess(file.stat().st_size, 3e6)
            if name != "animation":
                width = float(ElementTree.parse(file).getroot().get("width")[:-2])
                self.assertAlmostEqual(width, 3.5 * 72)
        self.assertEqual({file.name for file in (self.mission / "pictures").iterdir()},
                         {file.name for file in files.values()}, "nothing else is left there")
        for name, words in {
                "flight": ("position [m]", "yaw [°]", "velocity [m/s]", "commanded", "estimated", "true",
                           "no pose", "forward"),
                "pose_errors": ("across [mm]", "about up [°]", "±2σ as stated"),
                "offsets": ("distance d̄ [cm]", "error [mm]", "P2", "P3", "P4"),
                "overlay": ("model at the estimated pose", "44 × 44 pixels"),
                "map": ("along the flow, y [m]", "way-point", "3, 4", "times", "P5")}.items():
            for word in words:
                self.assertIn(word, texts(files[name]), name)
        self.assertNotIn("P1", texts(files["offsets"]), "it defines the frame")
        with Image.open(files["animation"]) as animation:
            self.assertEqual(animation.n_frames, 5, "one of the six images has no pose")

    def test_hot_spots_that_are_raised_at_the_end_are_in_the_map(self):
        self.assertNotIn("hot spot", texts(self.plot(self.mission)[0]["map"]))
        leaks = self.mission / "leaks"
        leaks.mkdir()
        (leaks / "events.csv").write_text("stamp,event,leak,state,x,y,z\n"
                                          "2001,raised,71,raised,0.2,4.0,0.35\n"
                                          "2002,raised,72,raised,1.1,5.0,0.4\n"
                                          "2003,cleared,72,cleared,1.1,5.0,0.4\n"
                                          "2004,raised,73,raised,,,\n")
        (leaks / "truth.csv").write_text("stamp,leak,x,y,z,length,delta\n2000,1,0.2,4.02,0.35,0.4,20\n")
        found = texts(self.plot(self.mission)[0]["map"])
        for word in ("true hot spot", "hot spot found", "71"):
            self.assertIn(word, found)
        for word in ("72", "73"):
            self.assertNotIn(word, found)

    def test_the_same_input_gives_the_same_bytes(self):
        first, _ = self.plot(self.mission, "--out", self.mission / "first")
        second, _ = self.plot(self.mission, "--out", self.mission / "second")
        self.assertEqual({name: file.read_bytes() for name, file in first.items()},
                         {name: file.read_bytes() for name, file in second.items()})

    def test_png_has_the_size_and_sharpness_of_a_column(self):
        for name in ("images.csv", "truth.csv", "offsets.csv"):
            (self.data / name).unlink()
        files, _ = self.plot(self.mission, "--format", "png")
        self.assertEqual(set(files), {"flight", "map"})
        with Image.open(files["map"]) as picture:
            self.assertEqual(picture.width, 1050)

    def test_a_real_flight_has_no_truth(self):
        (self.data / "truth.csv").unlink()
        mission = self.mission / "mission.yaml"
        mission.write_text(mission.read_text().replace("RackSimulation", "Camera"))
        files, err = self.plot(self.mission)
        self.assertEqual(set(files), PICTURES - {"pose_errors"})
        self.assertIn("ground truth is available in simulated flights", err)
        self.assertIn("minus last value", texts(files["offsets"]))
        self.assertNotIn("true", texts(files["flight"]))

    def test_what_is_missing_is_said_and_the_rest_is_drawn(self):
        for name in ("rack.yaml", "command.csv", "way_points.csv", "state.csv"):
            (self.data / name).unlink()
        (self.mission / "mission.yaml").unlink()
        files, err = self.plot(self.mission)
        self.assertEqual(set(files), WITHOUT_RACK)
        for words in ("its composition names none", "drawn without commands",
                      "way-points are not marked", "losses are not marked", "drawn without the rack"):
            self.assertIn(words, err)
        self.assertEqual(err.count("losses are not marked"), 1, "once, not for each picture")

    def test_a_simulation_of_the_same_rack_knows_where_the_pipes_lie(self):
        pipes = list(flights.TRUE_OFFSETS)
        mission = self.mission / "mission.yaml"
        whole = mission.read_text()
        self.assertEqual(read_true_offsets(self.recording(), pipes), flights.TRUE_OFFSETS)
        self.assertEqual(read_true_offsets(self.recording(), pipes[:4]), {}, "of another number of pipes")
        mission.write_text(whole.replace("rack: r.yaml", "rack: other.yaml", 1))
        self.assertEqual(read_true_offsets(self.recording(), pipes), {})
        mission.write_text(whole.replace(str(list(flights.TRUE_OFFSETS.values())), "[]"))
        self.assertEqual(read_true_offsets(self.recording(), pipes), dict.fromkeys(pipes, 0.0))
        mission.write_text(whole.replace(str(list(flights.TRUE_OFFSETS.values())), "[much]"))
        self.assertEqual(read_true_offsets(self.recording(), pipes), {})
        self.assertIn("true offsets of the pipes are not available", self.notes())

    def test_many_way_points_do_not_cover_each_other(self):
        stamps = numpy.linspace(flights.START, flights.START + 23, 100)
        rows = "".join(f"{stamp:.9f},{number},100,\n" for number, stamp in enumerate(stamps, 1))
        (self.data / "way_points.csv").write_text("stamp,done,of,message\n" + rows)
        numbers = [int(text) for text in re.findall(r">(\d+)</text>", self.errors_as_svg()) if int(text) > 20]
        self.assertLess(len(numbers), 40, "in two panels")
        self.assertIn("of 100 way-points are marked", self.notes())

    def test_way_points_of_another_clock_are_not_marked(self):
        self.replace("way_points.csv", f"\n{flights.START + 1.2:.9f}", "\n1795306988.1")
        with self.assertRaisesRegex(BadData, "way_points.csv"):
            errors.draw(self.recording())
        (self.data / "way_points.csv").write_text("stamp,done,of,message\n1795306988.1,1,4,\n")
        self.errors_as_svg()
        self.assertIn("1 way-points are not of the time of the flight", self.notes())

    def test_few_large_errors_do_not_set_the_axis(self):
        lines = (self.data / "pose.csv").read_text().splitlines()
        cells = lines[90].split(",")
        cells[3] = str(float(cells[3]) + 5.0)
        lines[90] = ",".join(cells)
        (self.data / "pose.csv").write_text("\n".join(lines) + "\n")
        figure = errors.draw(self.recording())
        self.assertLess(figure.axes[4].get_ylim()[1], 100, "mm, and one pose is 5 m too high")
        self.assertIn("error outside the axis", [text.get_text() for text in figure.legends[0].get_texts()])

    def test_no_offsets_at_all(self):
        (self.data / "offsets.csv").unlink()
        self.assertEqual(read_images(self.recording()).lines(0)[0].pixels.shape[1], 2)
        self.assertIn("without offsets", self.notes())
        with self.assertRaisesRegex(Missing, "no offsets.csv"):
            offsets.draw(self.recording())

    def test_bad_data_is_named_and_the_rest_is_drawn(self):
        self.replace("offsets.csv", ",P1,", ",P1,x")
        self.replace("rack.yaml", "radius: 0.15, length: 10, gap", "radius: -0.15, length: 10, gap")
        files, err = self.plot(self.mission, code=1)
        self.assertEqual(set(files), {"flight", "pose_errors"})
        self.assertIn("offsets.csv: line 2: column 'offset': 'x0.0' is not a number", err)
        self.assertIn("rack.yaml: line 8: 'radius' is not above 0", err)

    def test_a_pose_that_is_none_is_named(self):
        lines = (self.data / "pose.csv").read_text().splitlines()
        cells = lines[5].split(",")
        cells[2] = "nan"
        lines[5] = ",".join(cells)
        (self.data / "pose.csv").write_text("\n".join(lines) + "\n")
        files, err = self.plot(self.mission, code=1)
        self.assertEqual(set(files), {"offsets"})
        self.assertIn("pose.csv: line 6: column 'y': nan is not a finite number", err)

    def test_images_that_are_none(self):
        path = self.data / "images" / "000000.pgm"
        whole = path.read_bytes()
        for content, words in ((whole[:-100], "21500 pixels, and its header says 180 x 120"),
                               (b"", "not a binary PGM"), (b"P5\n180 120\n65535\n", "of 8 bits"),
                               (b"P5\n-1 120\n255\n", "not a binary PGM"), (b"P6\n1 1\n255\nabc", "PGM")):
            path.write_bytes(content)
            with self.assertRaisesRegex(BadData, words):
                read_images(self.recording()).read(self.recording(), 0)
        path.unlink()
        with self.assertRaisesRegex(BadData, "000000.pgm: No such file"):
            read_images(self.recording()).read(self.recording(), 0)
        self.replace("images.csv", "images/000000.pgm", "../../../etc/x.pgm")
        with self.assertRaisesRegex(Missing, "lies outside of"):
            read_images(self.recording()).read(self.recording(), 0)

    def test_images_of_another_camera(self):
        self.replace("camera.yaml", "image_width: 180", "image_width: 190")
        with self.assertRaisesRegex(Missing, "differs in size from camera.yaml"):
            read_images(self.recording()).read(self.recording(), 0)
        self.replace("camera.yaml", "157.5", ".nan")
        with self.assertRaisesRegex(BadData, "camera_matrix is not that of a camera"):
            read_images(self.recording())
        self.replace("camera.yaml", "camera_matrix", "matrix")
        with self.assertRaisesRegex(BadData, "camera.yaml: not a calibration in the format of ROS"):
            read_images(self.recording())

    def test_a_run_that_was_killed_is_drawn_up_to_there(self):
        content = (self.data / "pose.csv").read_text()
        (self.data / "pose.csv").write_text(content[:-25])
        errors.draw(self.recording())
        self.assertIn("has no line end and is left out", self.notes())

    def test_a_mission_file_that_is_none(self):
        (self.mission / "mission.yaml").write_text("components: [7]\n")
        self.assertEqual(len(read_servo(self.recording()).way_points), 0)
        self.assertIn("parameters of the visual servo are not available", self.notes())

    def test_a_camera_beside_the_middle_of_the_vehicle(self):
        mission = self.mission / "mission.yaml"
        mission.write_text(mission.read_text().replace(
            "summary:", "      camera:\n        position: [0.1, 0, -0.05]\n"
            "        roll_pitch_yaw: [3.14159265359, 0, 0]\nsummary:"))
        servo = read_servo(self.recording())
        self.assertEqual(servo.way_points.shape, (4, 4))
        camera = Poses(numpy.zeros(1), numpy.array([[1.0, 2.0, 3.0]]), numpy.array([[1.0, 0, 0, 0]]))
        numpy.testing.assert_allclose(servo.vehicle(camera).positions, [[0.9, 2.0, 3.05]], atol=1e-9)

    def test_several_flights_are_told_apart_by_their_folder(self):
        for name in ("images.csv", "truth.csv", "offsets.csv"):
            (self.data / name).unlink()
        shutil.copytree(self.data, self.mission / "robot_2" / "rack")
        files, _ = self.plot(self.mission)
        self.assertEqual(set(files), {f"{folder}.{name}" for folder in ("rack", "robot_2.rack")
                                      for name in ("flight", "map")})

    def test_nothing_to_draw_is_an_error(self):
        shutil.rmtree(self.data)
        files, err = self.plot(self.mission, code=1)
        self.assertEqual(files, {})
        self.assertIn("nothing that can be drawn in", err)
        _, err = self.plot(self.mission / "gone", code=1)
        self.assertIn("no folder or file", err)

    def test_a_reproduction(self):
        file = flights.reproduction(Path(self._folder.name) / "rack.json")
        files, err = self.plot(file)
        self.assertEqual(set(files), {"table1", "figures"})
        self.assertEqual(err, "")
        for words in ("2 pipes", "5 pipes", "paper", "ours, 20 samples", "ours, 50 samples",
                      "error / bound", "position [cm]"):
            self.assertIn(words, texts(files["table1"]))
        self.assertIn("table1_cells_half_of_paper", texts(files["figures"]))
        file.write_text('{"rows": [{"study": "Table I: 20 samples an edge", "pipes": "x"}]}')
        _, err = self.plot(file, code=1)
        self.assertIn("has no rows of Table I", err)
        file.write_text("[]")
        _, err = self.plot(file, code=1)
        self.assertIn("no list 'rows'", err)

    def test_a_flight_is_no_matter_of_odometry(self):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            self.assertEqual(main(["odometry", str(self.mission)]), 1)
        self.assertIn("holds nothing of 'odometry', but", err.getvalue())


if __name__ == "__main__":
    unittest.main()
