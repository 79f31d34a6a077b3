# SPDX-License-Identifier: Apache-2.0
"""`pipescout plot` draws what each tool writes, told by the files alone, and else says what does."""

from __future__ import annotations

import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import flights
import lists
import missions
import runs
from pictures import paths
from pipescout_plots.command_line import SUBJECTS, main
from pipescout_plots.contents import ANY_NAME
from pipescout_plots.subjects import KINDS, REPRODUCTION


class Contents(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def plot(self, *arguments, code=0):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            self.assertEqual(main([*map(str, arguments)]), code, err.getvalue())
        return [path.name for path in paths(out.getvalue())], err.getvalue()

    def write(self, name: str, text: str = "") -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def test_what_each_tool_writes_is_drawn(self):
        for make, drawn in (
                (lists.trajectory, ["trajectory.svg", "uncertainty.svg"]),
                (lists.camera_poses, ["map.svg", "flight.svg"]),
                (lists.image_track, ["track.svg"]),
                (lists.leaks, ["leaks.svg"]),
                (lists.seen_leaks, ["leak_timeline.svg"]),
                (missions.crawler, ["support_graph.svg", "position_error.svg", "eddy_current.svg"])):
            with self.subTest(drawn=drawn):
                folder = self.folder / make.__name__
                make(folder)
                names, err = self.plot(folder)
                self.assertEqual(names, drawn)
                self.assertNotIn("error", err)
                self.assertNotIn("not drawn:", err)

    def test_a_list_of_any_name_is_drawn_next_to_it(self):
        for make, drawn in ((lists.ledger, "ledger.svg"), (lists.welds, "welds.svg"),
                            (missions.alignment, "ledger_alignment.svg")):
            with self.subTest(drawn):
                file = self.folder / make.__name__ / "2026 run.csv"
                self.assertEqual(self.plot(make(file)), ([drawn], ""))
                self.assertTrue((file.parent / "pictures" / drawn).is_file())

    def test_several_lists_of_a_kind_are_told_apart_by_their_names(self):
        lists.ledger(self.folder / "old.csv")
        lists.ledger(self.folder / "new.csv")
        self.assertEqual(self.plot(self.folder)[0], ["new.ledger.svg", "old.ledger.svg"])

    def test_pictures_of_one_name_are_told_apart_by_their_folders(self):
        lists.camera_poses(self.folder / "poses")
        flights.flight(self.folder, seconds=8.0, rate=10.0, width=120, image_period=9.0)
        names, _ = self.plot(self.folder)
        self.assertLessEqual({"rack.map.svg", "poses.map.svg", "rack.flight.svg", "poses.flight.svg"}, set(names))

    def test_a_mission_is_drawn_as_a_whole_and_a_subject_alone(self):
        runs.run(self.folder, seconds=20.0)
        flights.flight(self.folder, seconds=8.0, rate=10.0, width=120, image_period=4.0)
        whole, _ = self.plot(self.folder)
        self.assertEqual(len(set(whole)), len(whole), "no picture takes the place of another")
        self.assertLessEqual({"pose_errors.svg", "errors.svg", "map.svg", "sources.svg", "animation.gif"}, set(whole))
        alone, _ = self.plot("estimator", self.folder)
        self.assertEqual(alone, [name for name in whole if name in alone])
        self.assertNotIn("map.svg", alone)

    def test_a_table_that_is_named_draws_its_folder(self):
        folder = lists.trajectory(self.folder / "out")
        self.assertEqual(self.plot(folder / "trajectory.csv")[0], ["trajectory.svg", "uncertainty.svg"])

    def test_another_subject_is_named(self):
        folder = lists.image_track(self.folder / "out")
        _, err = self.plot("rack", folder, code=1)
        self.assertIn(f"a pipe tracked through images: `pipescout plot tracking {folder}`", err)

    def test_columns_that_nothing_has_are_named(self):
        self.write("out/track.csv", "stamp,x,y\n1,2,3\n")
        names, err = self.plot(self.folder / "out", code=1)
        self.assertEqual(names, [])
        self.assertIn("track.csv: line 1: no column 'u' (a tracked pipe and the arm) or 'x_sd' (a pipe tracked", err)

    def test_what_has_no_tables_says_what_draws_it(self):
        for name, text, words in (("bag/mission.mcap", "", "pipescout summary"),
                                  ("map/plant.yaml", "image: p.pgm\nresolution: 0.1\n", "pipescout map show"),
                                  ("drawn/map.png", "", "pictures already: "),
                                  ("failed/report.md", "# No trajectory\n", "report.md says what came of it"),
                                  ("other/notes.csv", "a,b\n1,2\n", "no tables of a mission")):
            with self.subTest(name):
                file = self.write(name, text)
                for result in (file, file.parent):
                    names, err = self.plot(result, code=1)
                    self.assertEqual(names, [])
                    self.assertIn(words, err)

    def test_of_a_json_file_that_has_no_rows_it_is_said(self):
        _, err = self.plot(self.write("summary.json", '{"welds": 3}'), code=1)
        self.assertEqual(err.count("no list 'rows'"), 1)

    def test_a_reproduction_needs_no_subject(self):
        self.assertEqual(self.plot(missions.reproduction(self.folder / "in_pipe.json")),
                         (["detector_curve.svg", "rules_in_bends.svg", "figures.svg"], ""))

    def test_a_wrong_command_line(self):
        for words in ([], ["rack"], ["racks", "m"], ["rack", "m", "n"]):
            with self.subTest(words), contextlib.redirect_stderr(io.StringIO()), \
                    self.assertRaises(SystemExit) as caught:
                main(words)
            self.assertEqual(caught.exception.code, 2)


class Kinds(unittest.TestCase):
    def test_each_has_a_subject_that_is_listed_and_pictures_that_are_explained(self):
        pictures = [(kind.subject, picture) for kind in KINDS for picture in kind.pictures] + list(REPRODUCTION)
        for subject, picture in pictures:
            self.assertIn(subject, [*SUBJECTS, None])
            self.assertGreater(len(picture.shows), 20, picture.name)
            self.assertNotIn("\n", picture.shows)

    def test_no_list_is_of_two_kinds(self):
        wanted = [kind.files[ANY_NAME] for kind in KINDS if ANY_NAME in kind.files]
        for k, columns in enumerate(wanted):
            for others in wanted[:k]:
                self.assertFalse(columns <= others or others <= columns)


if __name__ == "__main__":
    unittest.main()
