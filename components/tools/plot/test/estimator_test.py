# SPDX-License-Identifier: Apache-2.0
"""The whole command on small runs of a state estimator."""

import contextlib
import io
import shutil
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy
import runs
from pictures import paths
from pipescout_plots import style
from pipescout_plots.command_line import main
from pipescout_plots.estimator import residuals, sources, trajectory
from pipescout_plots.estimator.run_data import (Factors, nearest, read_errors, read_estimates, read_sources,
                                                read_states)
from pipescout_plots.recording import Missing, Recording

PICTURES = {"trajectory", "errors", "consistency", "residuals", "sources", "biases"}


def texts(file: Path) -> str:
    return " ".join(ElementTree.parse(file).getroot().itertext())


class Estimator(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.made = Path(folder.name) / "mission"
        runs.run(cls.made)

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.mission = Path(self._folder.name) / "mission"
        shutil.copytree(self.made, self.mission)
        self.data = self.mission / "estimator"

    def plot(self, *arguments, code=0):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            self.assertEqual(main(["estimator", *map(str, arguments)]), code, err.getvalue())
        return {Path(path).stem: Path(path) for path in paths(out.getvalue())}, err.getvalue()

    def recording(self) -> Recording:
        return Recording(self.mission, self.data)

    def keep(self, *names: str):
        for path in self.mission.rglob("*.csv"):
            if path.name not in names:
                path.unlink()

    def test_a_run_gets_its_pictures(self):
        files, err = self.plot(self.mission)
        self.assertEqual(set(files), PICTURES)
        self.assertEqual(err, "")
        for file in files.values():
            self.assertEqual(file.parent, self.mission / "pictures")
            self.assertLess(file.stat().st_size, 1e6)
            width = float(ElementTree.parse(file).getroot().get("width")[:-2])
            self.assertAlmostEqual(width, 3.5 * 72)
        for name, words in {
                "trajectory": ("x [m]", "y [m]", "true", "GPS accepted", "GPS gated (12 of 26 outside, up to 6", "2σ"),
                "errors": ("x error [m]", "heading error [°]", "±2σ as stated", "time [s]"),
                "consistency": ("NEES of position", "NEES of pose", "expected: 3", "expected: 6"),
                "residuals": ("gps: 212 accepted, 26 gated", "zero velocity: 0 accepted, 1 quarantined",
                              "weight below 0.5", "χ² per degree of freedom"),
                "sources": ("estimator", "visual pose", "trusted, running", "gated measurement", "restart",
                            "without absolute"),
                "biases": ("gyro bias [mrad/s]", "odometer scale", "±2σ")}.items():
            for word in words:
                self.assertIn(word, texts(files[name]), name)

    def test_the_same_input_gives_the_same_bytes(self):
        first, _ = self.plot(self.mission, "--out", self.mission / "first")
        second, _ = self.plot(self.mission, "--out", self.mission / "second")
        self.assertEqual({name: file.read_bytes() for name, file in first.items()},
                         {name: file.read_bytes() for name, file in second.items()})

    def test_a_real_run_has_no_truth(self):
        for name in ("truth.csv", "errors.csv"):
            (self.data / name).unlink()
        files, err = self.plot(self.mission)
        self.assertEqual(set(files), PICTURES - {"errors", "consistency"})
        self.assertIn("ground truth is available in simulated runs", err)
        self.assertNotIn("true", texts(files["trajectory"]))

    def test_what_is_missing_is_said_and_the_rest_is_drawn(self):
        for name in ("factors.csv", "gps.csv", "state.csv"):
            (self.data / name).unlink()
        files, err = self.plot(self.mission)
        self.assertEqual(set(files), {"trajectory", "errors", "consistency"})
        self.assertIn("not drawn: residuals: no factors.csv", err)
        self.assertIn("not drawn: sources: no state.csv", err)

    def test_fixes_of_which_nothing_is_told_were_not_used(self):
        self.keep("estimate.csv", "gps.csv", "state.csv", "sources.csv")
        files, err = self.plot(self.mission)
        self.assertIn("GPS fix (12 of 250 outside, up to 6", texts(files["trajectory"]))
        self.assertNotIn("GPS accepted", texts(files["trajectory"]))
        self.assertEqual(err.count("outcomes of single measurements are not available"), 1, "once")

    def test_a_crawler_has_no_gps_and_hears_of_no_absolute_position(self):
        mission = self.mission / "crawler"
        runs.run(mission, seconds=62.0, crawler=True)
        files, _ = self.plot(mission)
        self.assertEqual(set(files), PICTURES)
        self.assertNotIn("GPS", texts(files["trajectory"]))
        self.assertNotIn("without absolute", texts(files["sources"]))
        self.assertIn("weld: 4 accepted, 1 late", texts(files["residuals"]))

    def test_several_robots(self):
        runs.run(self.mission / "robot_2", seconds=20.0)
        self.keep("factors.csv")
        files, _ = self.plot(self.mission)
        self.assertEqual(set(files), {"estimator.residuals", "robot_2.estimator.residuals"})

    def test_an_estimator_that_never_ran(self):
        for name in ("estimate.csv", "errors.csv", "factors.csv", "gps.csv", "truth.csv"):
            (self.data / name).unlink()
        lines = (self.data / "state.csv").read_text().splitlines(keepends=True)
        (self.data / "state.csv").write_text("".join(lines[:20]))
        files, err = self.plot(self.mission)
        self.assertEqual(set(files), {"sources"})
        self.assertIn("no state of a running estimator", err)

    def test_a_single_row_of_everything(self):
        for path in self.data.glob("*.csv"):
            path.write_text("".join(path.read_text().splitlines(keepends=True)[:2]))
        files, err = self.plot(self.mission)
        self.assertEqual(set(files), PICTURES - {"biases"}, err)

    def test_bad_data_is_named(self):
        self.keep("estimate.csv", "factors.csv")
        path = self.data / "estimate.csv"
        path.write_text(path.read_text().replace("3006.000000000,", "soon,", 1))
        files, err = self.plot(self.mission, code=1)
        self.assertEqual(set(files), {"residuals"}, "the others are drawn all the same")
        self.assertIn("estimate.csv: line 2: column 'stamp': 'soon' is not a number", err)

    def test_nothing_to_draw(self):
        _, err = self.plot(self.mission / "gone", code=1)
        self.assertIn("no folder or file", err)
        (self.mission / "empty").mkdir()
        _, err = self.plot(self.mission / "empty", code=1)
        self.assertIn("nothing that can be drawn in", err)

    def test_of_a_reproduction_the_figures_are_drawn(self):
        files, _ = self.plot(runs.reproduction(self.mission / "estimator.json"))
        self.assertEqual(set(files), {"figures"})
        self.assertIn("outage_drift_percent", texts(files["figures"]))

    def test_it_is_no_flight_over_a_rack(self):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            self.assertEqual(main(["rack", str(self.mission)]), 1)
        self.assertIn("holds nothing of 'rack', but", err.getvalue())

    def test_what_the_estimates_say_of_their_errors_is_that_of_the_same_time(self):
        run = read_errors(self.recording())
        estimates = read_estimates(self.recording())
        numpy.testing.assert_array_equal(run.deviations, estimates.deviations)
        lines = (self.data / "estimate.csv").read_text().splitlines(keepends=True)
        (self.data / "estimate.csv").write_text("".join(lines[:1] + lines[2:]))
        run = read_errors(self.recording())
        self.assertTrue(numpy.isnan(run.deviations[0]).all(), "there is no estimate of that time")
        numpy.testing.assert_array_equal(run.deviations[1:], estimates.deviations[1:])

    def test_a_state_of_no_time_is_of_the_first_one(self):
        states = read_states(self.recording(), [], ["phase"])
        self.assertEqual(states.numbers["stamp"][0], runs.START)
        self.assertEqual(read_sources(self.recording(), states).numbers["stamp"][0], runs.START)

    def test_png(self):
        self.keep("estimate.csv")
        files, _ = self.plot(self.mission, "--format", "png", "--out", self.mission / "p")
        self.assertEqual(files, {"trajectory": self.mission / "p" / "trajectory.png"})


class Parts(unittest.TestCase):
    def test_the_nearest_stamp_and_whether_it_is_the_same(self):
        rows, same = nearest(numpy.array([1.0, 2.0, 3.0]), numpy.array([0.0, 1.4, 2.0000001, 2.6, 9.0]))
        self.assertEqual(rows.tolist(), [0, 0, 1, 2, 2])
        self.assertEqual(same.tolist(), [False, False, True, False, False])
        rows, same = nearest(numpy.array([5.0]), numpy.array([5.0, 6.0]))
        self.assertEqual((rows.tolist(), same.tolist()), ([0, 0], [True, False]))

    def test_factors_are_sorted_by_how_much_they_were_believed(self):
        outcomes = ["accepted", "accepted", "accepted", "gated", "quarantined", "late"]
        factors = Factors(numpy.zeros(6), numpy.array(["gps"] * 6, dtype=object),
                          numpy.array(outcomes, dtype=object), numpy.zeros(6),
                          numpy.array([1.0, 0.5, 0.1, 0.0, 0.0, 0.0]))
        self.assertEqual(residuals.classes(factors).tolist(), [0, 1, 2, 3, 4, 5])

    def test_a_state_lasts_until_the_next_one(self):
        held = sources.spans(numpy.array([1.0, 2.0, 3.0, 5.0]),
                             numpy.array(["absent", "trusted", "trusted", "absent"], dtype=object), 9.0)
        self.assertEqual(held, {"absent": [(1.0, 2.0), (5.0, 9.0)], "trusted": [(2.0, 5.0)]})

    def test_of_the_time_without_an_absolute_position_the_tips_are_shown(self):
        stamps = numpy.arange(0, 1000, 0.1)
        since = stamps % 0.5
        since[5000:5200] = numpy.arange(200) * 0.1
        since[:50] = numpy.nan
        edges, longest = sources.longest_since(stamps, since, 1000.0)
        self.assertEqual((edges[0], edges[-1]), (0.0, 1000.0))
        self.assertEqual(len(longest), len(edges) - 1)
        self.assertLess(len(longest), 200, "lines of a saw tooth that is finer are a block")
        self.assertAlmostEqual(numpy.nanmax(longest), 19.9)
        self.assertAlmostEqual(numpy.nanmedian(longest), 0.4)
        self.assertAlmostEqual(longest[int(numpy.argmax(edges > 519.9)) - 1], 19.9)

    def test_the_panel_shows_all_fixes_that_were_accepted(self):
        path = numpy.stack((numpy.arange(10.0), numpy.zeros(10), numpy.zeros(10)), axis=-1)
        fixes = trajectory.Fixes(numpy.array([[3.0, 25.0], [700.0, 0.0], [numpy.nan, 0.0]]),
                                 numpy.array(["accepted", "gated", "accepted"], dtype=object))
        low, high = trajectory.frame(path, numpy.empty((0, 3)), fixes)
        self.assertGreater(high[1], 25)
        self.assertLess(high[0], 100, "the path would be a dot")
        alone, _ = trajectory.frame(path, numpy.empty((0, 3)), None)
        self.assertLessEqual(alone[0], 0)

    def test_fixes_in_another_frame_are_told(self):
        style.begin()
        with tempfile.TemporaryDirectory() as folder:
            data = runs.run(Path(folder), seconds=30.0)
            lines = (data / "gps.csv").read_text().splitlines()
            moved = [line.split(",") for line in lines[1:]]
            (data / "gps.csv").write_text("\n".join([lines[0], *(
                ",".join([*cells[:4], str(float(cells[4]) + 500), *cells[5:]]) for cells in moved)]) + "\n")
            (data / "factors.csv").unlink()
            recording = Recording(Path(folder), data)
            figure = trajectory.draw(recording)
            labels = [text.get_text() for text in figure.legends[0].get_texts()]
            self.assertTrue(any(label.startswith(f"GPS fix ({len(moved)} of {len(moved)} outside, up to ")
                                for label in labels), labels)
            self.assertIn("gps.csv is in another frame than the estimate", "".join(recording.notes))

    def test_a_folder_without_factors_has_no_residuals(self):
        style.begin()
        with tempfile.TemporaryDirectory() as folder, self.assertRaises(Missing):
            residuals.draw(Recording(Path(folder), Path(folder)))


if __name__ == "__main__":
    unittest.main()
