# SPDX-License-Identifier: Apache-2.0
"""The whole command on small missions."""

import contextlib
import io
import struct
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import missions
from pictures import paths
from pipescout_plots.command_line import main

CRAWLER = {"support_graph", "position_error", "eddy_current"}


class Odometry(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.mission = Path(self._folder.name) / "mission"

    def plot(self, *arguments, code=0):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            self.assertEqual(main(["odometry", *map(str, arguments)]), code, err.getvalue())
        return paths(out.getvalue()), err.getvalue()

    def test_a_crawler_gets_its_pictures(self):
        missions.crawler(self.mission)
        missions.alignment(self.mission / "alignment.csv")
        files, err = self.plot(self.mission)
        self.assertEqual({file.stem for file in files}, CRAWLER | {"ledger_alignment"})
        for file in files:
            self.assertEqual(file.parent, self.mission / "pictures")
            self.assertLess(file.stat().st_size, 1e6)
            root = ElementTree.parse(file).getroot()
            self.assertAlmostEqual(float(root.get("width")[:-2]), 3.5 * 72)
        self.assertEqual(err, "", "what is of other missions is not missed")
        self.assertEqual({file.name for file in (self.mission / "pictures").iterdir()},
                         {file.name for file in files}, "nothing else is left there")

    def test_texts_stay_texts(self):
        missions.crawler(self.mission)
        files, _ = self.plot(self.mission)
        texts = {file.stem: "".join(ElementTree.parse(file).getroot().itertext()) for file in files}
        for words in ("wheel_2", "slipping", "unsupported", "no consensus", "time [s]", "1–2"):
            self.assertIn(words, texts["support_graph"])
        for words in ("position error [m]", "locked from 6.0 m", "double slip", "outside the axis"):
            self.assertIn(words, texts["position_error"])
        self.assertIn("W,2", texts["eddy_current"])

    def test_the_same_input_gives_the_same_bytes(self):
        missions.crawler(self.mission)
        missions.alignment(self.mission / "alignment.csv")
        for form in ("svg", "png"):
            first, _ = self.plot(self.mission, "--format", form)
            before = [file.read_bytes() for file in first]
            second, _ = self.plot(self.mission, "--format", form)
            self.assertEqual(before, [file.read_bytes() for file in second])
            self.assertEqual(len(before), 4)

    def test_png_has_the_size_and_sharpness_of_a_column(self):
        missions.readings(self.mission)
        (file,), _ = self.plot(self.mission, "--format", "png", "--out", self.mission / "there" / "deep")
        self.assertEqual(file, self.mission / "there" / "deep" / "readings.png")
        content = file.read_bytes()
        self.assertEqual(struct.unpack(">I", content[16:20])[0], 1050)

    def test_single_readings_are_drawn_with_their_offsets(self):
        missions.readings(self.mission)
        files, err = self.plot(self.mission)
        self.assertEqual([file.name for file in files], ["readings.svg"])
        self.assertEqual(err, "")
        missions.readings(self.mission, offsets="[0.1]")
        _, err = self.plot(self.mission)
        self.assertIn("note: ", err)
        self.assertIn("1 offsets for 2 odometers", err)

    def test_many_odometers_get_a_row_each(self):
        data = self.mission / "crawler"
        wheels = [f"w{k}.rejection" for k in range(1, 9)]
        missions.write_csv(data / "fused.csv", ["stamp", "distance", "status", "support", *wheels],
                           [(k, k, "ok", "1>2 2>1 3>2 4>2 5>2", *["none"] * 7, "absent") for k in range(9)])
        (file,), _ = self.plot(self.mission)
        text = "".join(ElementTree.parse(file).getroot().itertext())
        self.assertIn("supported", text)
        self.assertNotIn("1–2", text)

    def test_one_odometer_alone(self):
        missions.write_csv(self.mission / "crawler/fused.csv",
                           ["stamp", "distance", "status", "support", "w.rejection"],
                           [(1, "nan", "no data", "", "absent")])
        (file,), _ = self.plot(self.mission)
        self.assertEqual(file.stem, "support_graph")

    def test_odometers_that_flicker_stay_a_small_file(self):
        wheels = [f"w{k}.rejection" for k in range(1, 17)]
        agreed = " ".join(f"{i}>{j}" for i in range(1, 17) for j in range(1, 17) if i != j)
        rows = [(k, k, "ok", agreed if k % 2 else "", *["none" if k % 3 else "drifted"] * 16)
                for k in range(20000)]
        missions.write_csv(self.mission / "crawler/fused.csv",
                           ["stamp", "distance", "status", "support", *wheels], rows)
        (file,), _ = self.plot(self.mission)
        self.assertLess(file.stat().st_size, 1e6)

    def test_several_recordings_are_told_apart_by_their_folder(self):
        missions.readings(self.mission / "robot_1")
        missions.readings(self.mission / "robot_2")
        files, err = self.plot(self.mission)
        self.assertEqual([file.name for file in files],
                         ["robot_1.odometry.readings.svg", "robot_2.odometry.readings.svg"])
        self.assertIn("drawn without", err, "there is no mission.yaml at the top")

    def test_without_welds_the_rest_is_drawn(self):
        data = missions.crawler(self.mission)
        (data / "welds.csv").write_text("stamp,distance,confidence,weld_id\n")
        files, err = self.plot(self.mission)
        self.assertEqual({file.stem for file in files}, CRAWLER)
        self.assertIn("note: eddy_current has no welds", err)

    def test_without_truth_there_is_no_error(self):
        (missions.crawler(self.mission) / "truth.csv").unlink()
        files, err = self.plot(self.mission)
        self.assertEqual({file.stem for file in files}, CRAWLER - {"position_error"})
        self.assertIn("ground truth is available in simulated runs only", err)

    def test_never_certain_of_its_joint(self):
        data = missions.crawler(self.mission, seconds=15)
        files, _ = self.plot(self.mission)
        self.assertIn("position_error", {file.stem for file in files})
        self.assertNotIn("locked from", (data.parent / "pictures/position_error.svg").read_text())

    def test_bad_data_is_named_and_the_rest_is_drawn(self):
        data = missions.crawler(self.mission)
        lines = (data / "welds.csv").read_text().splitlines()
        lines[1] = lines[1].replace("0.91", "high")
        (data / "welds.csv").write_text("\n".join(lines) + "\n")
        files, err = self.plot(self.mission, code=1)
        self.assertEqual({file.stem for file in files}, CRAWLER - {"eddy_current"})
        self.assertIn("welds.csv: line 2: column 'confidence': 'high' is not a number", err)

    def test_a_run_that_was_killed_is_drawn_up_to_there(self):
        data = missions.crawler(self.mission)
        content = (data / "fused.csv").read_text()
        (data / "fused.csv").write_text(content[:-25])
        files, err = self.plot(self.mission)
        self.assertEqual({file.stem for file in files}, CRAWLER)
        self.assertIn("note: ", err)
        self.assertIn("has no line end and is left out", err)

    def test_a_clock_that_goes_back_is_named(self):
        data = missions.crawler(self.mission)
        lines = (data / "fused.csv").read_text().splitlines()
        (data / "fused.csv").write_text("\n".join([*lines, lines[1]]) + "\n")
        _, err = self.plot(self.mission, code=1)
        self.assertIn("fused.csv: line 1002: column 'stamp'", err)

    def test_a_signal_of_another_time(self):
        data = missions.crawler(self.mission)
        missions.write_csv(data / "eddy_current.csv", ["stamp", "x1", "y1"], [(1, 1, 1), (2, 1, 1)])
        files, err = self.plot(self.mission)
        self.assertEqual({file.stem for file in files}, CRAWLER - {"eddy_current"})
        self.assertIn("no sample within the time of", err)

    def test_nothing_to_draw_is_an_error(self):
        self.mission.mkdir()
        files, err = self.plot(self.mission, code=1)
        self.assertEqual(files, [])
        self.assertIn("nothing that can be drawn in", err)
        self.assertFalse((self.mission / "pictures").exists())
        _, err = self.plot(self.mission / "gone", code=1)
        self.assertIn("no folder or file", err)

    def test_a_folder_that_cannot_be_written(self):
        missions.readings(self.mission)
        (self.mission / "pictures").write_text("a file is in the way")
        _, err = self.plot(self.mission, code=1)
        self.assertIn("error: readings: ", err)

    def test_an_alignment_elsewhere(self):
        file = missions.alignment(Path(self._folder.name) / "elsewhere.csv")
        (drawn,), _ = self.plot(file)
        self.assertEqual(drawn, file.parent / "pictures/ledger_alignment.svg")
        text = "".join(ElementTree.parse(drawn).getroot().itertext())
        for words in ("only in the run", "only in the ledger", "probability < 0.99", "stretch [%]"):
            self.assertIn(words, text)

    def test_a_reproduction(self):
        file = missions.reproduction(Path(self._folder.name) / "in_pipe.json")
        files, _ = self.plot(file)
        self.assertEqual([file.name for file in files], ["detector_curve.svg", "rules_in_bends.svg", "figures.svg"])
        file.write_text("[]")
        _, err = self.plot(file, code=1)
        self.assertIn("no list 'rows'", err)
        file.write_text("{")
        _, err = self.plot(file, code=1)
        self.assertIn("in_pipe.json: ", err)

    def test_a_wrong_command_line(self):
        for arguments in (["thermal", "m"], ["odometry"], ["odometry", "m", "--format", "jpg"]):
            with contextlib.redirect_stderr(io.StringIO()), self.assertRaises(SystemExit) as caught:
                main(arguments)
            self.assertEqual(caught.exception.code, 2)
