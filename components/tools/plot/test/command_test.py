# SPDX-License-Identifier: Apache-2.0
"""The executable `pipescout-plot`, on small missions made here."""

from __future__ import annotations

import os
import stat
import subprocess
import tempfile
import unittest
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
PYTHON = "/usr/bin/python3"  # Debian's, which sees Debian's matplotlib
CAN_DRAW = subprocess.run([PYTHON, "-c", "import matplotlib, yaml"], stderr=subprocess.DEVNULL,
                          check=False).returncode == 0
needs_matplotlib = unittest.skipUnless(
    CAN_DRAW, f"NOTHING IS TESTED: {PYTHON} has no matplotlib or no yaml; install the Debian packages "
    "python3-matplotlib and python3-yaml")


def paths(out: str) -> list[str]:
    """Of the pictures, each printed with what it shows."""
    return [line.split("\t")[0] for line in out.splitlines()]


class PlotCommand(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        # As it is installed.
        (self.folder / "prefix/bin").mkdir(parents=True)
        (self.folder / "prefix/share").mkdir()
        (self.folder / "prefix/bin/pipescout-plot").symlink_to(PACKAGE / "pipescout-plot")
        (self.folder / "prefix/share/pipescout_plot").symlink_to(PACKAGE)
        self.python: str | None = None
        self.write("m/odometry/readings.csv",
                   "reading,stamp,a,b,a.standard_deviation,b.standard_deviation,a.valid,b.valid\n"
                   "1,1.0,5.1,5.0,0.05,0.05,1,1\n2,1.1,5.2,5.1,0.05,0.05,1,1\n")
        self.write("m/odometry/fused.csv",
                   "reading,stamp,distance,standard_deviation,status,fusion_set,a.rejection,b.rejection\n"
                   "1,1.0,5.05,0.03,ok,1 2,none,none\n2,1.1,5.15,0.03,ok,1 2,none,none\n")

    def write(self, name: str, text: str) -> None:
        (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
        (self.folder / name).write_text(text)

    def read(self, name: str) -> bytes:
        return (self.folder / name).read_bytes()

    def plot(self, *arguments: str, code: int = 0) -> tuple[str, str]:
        environment = {name: value for name, value in os.environ.items() if name != "PIPESCOUT_PYTHON"}
        if self.python is not None:
            environment["PIPESCOUT_PYTHON"] = self.python
        done = subprocess.run([self.folder / "prefix/bin/pipescout-plot", *arguments], cwd=self.folder,
                              env=environment, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stdout, done.stderr


class Completing(PlotCommand):
    """What a shell asks when the user presses the tab key."""

    def complete(self, *words: str) -> list[str]:
        return self.plot("__complete", "--", *words)[0].split()

    def test_subjects_options_and_values(self):
        self.assertEqual(self.complete("od"), ["odometry"])
        self.assertEqual(self.complete("rack", "--f"), ["--format"])
        self.assertEqual(self.complete("rack", "--format", ""), ["png", "svg"])
        self.assertEqual(self.complete("--format=s"), ["--format=svg"])
        self.assertEqual(self.complete("--format", "png", "ra"), ["rack"])

    def test_leaves_files_to_the_shell(self):
        self.assertEqual(self.complete("rack", ""), [])
        self.assertEqual(self.complete("--out", ""), [])


@needs_matplotlib
class Drawing(PlotCommand):
    def test_prints_the_path_of_each_picture(self):
        out, err = self.plot("odometry", "m")
        self.assertEqual(paths(out), ["m/pictures/readings.svg"])
        self.assertNotIn("not drawn", err)
        picture = self.read("m/pictures/readings.svg")
        self.assertTrue(picture.startswith(b"<?xml"))
        self.assertIn(b"in the fusion set", picture)

    def test_writes_png_to_another_folder(self):
        out, _ = self.plot("odometry", "--out", "-p", "--format", "png", "m")
        self.assertEqual(paths(out), ["-p/readings.png"])
        self.assertTrue(self.read("-p/readings.png").startswith(b"\x89PNG"))

    def test_a_mission_folder_may_begin_with_a_dash(self):
        (self.folder / "m").rename(self.folder / "-m")
        out, _ = self.plot("odometry", "--out=p", "--", "-m")
        self.assertEqual(paths(out), ["p/readings.svg"])

    def test_nothing_to_draw_is_an_error(self):
        _, err = self.plot("odometry", "gone", code=1)
        self.assertIn("no folder or file 'gone'", err)
        (self.folder / "empty").mkdir()
        out, err = self.plot("odometry", "empty", code=1)
        self.assertEqual(out, "")
        self.assertIn("nothing that can be drawn in empty", err)

    def test_names_bad_data(self):
        self.write("m/odometry/readings.csv",
                   "reading,stamp,a,a.standard_deviation,a.valid\n1,1.0,much,0.05,1\n")
        _, err = self.plot("odometry", "m", code=1)
        self.assertIn("readings.csv: line 2: column 'a': 'much' is not a number", err)

    def test_draws_a_state_estimator(self):
        self.write("e/estimator/factors.csv",
                   "stamp,kind,outcome,chi_square,degrees,weight\n"
                   "1000.1,gps,accepted,2.5,3,1\n1000.2,gps,gated,300,3,0\n")
        out, err = self.plot("estimator", "e")
        self.assertEqual(paths(out), ["e/pictures/residuals.svg"])
        self.assertIn("not drawn: trajectory: no estimate.csv", err)
        self.assertIn(b"gps: 1 accepted, 1 gated", self.read("e/pictures/residuals.svg"))


@needs_matplotlib
class RackDrawing(PlotCommand):
    """A flight over a rack of two pipes, as its tables have it."""

    POSES = 25

    def setUp(self):
        super().setUp()
        pose_columns = "stamp,x,y,z,qx,qy,qz,qw"
        poses = [pose_columns + ",x_standard_deviation,y_standard_deviation,z_standard_deviation,"
                 "rotation_x_standard_deviation,rotation_y_standard_deviation,"
                 "rotation_z_standard_deviation,x_y_correlation"]
        truth = [pose_columns]
        states = ["stamp,status"]
        offsets = ["stamp,pipe,offset,standard_deviation,observed"]
        commands = ["stamp,linear_x,linear_y,linear_z,angular_x,angular_y,angular_z"]
        images = ["stamp,file"]
        for k in range(self.POSES):
            stamp = f"{1000 + 0.04 * k:.6f}"
            along = f"{2 + 0.01 * k:.6f}"
            rest = "1.5,1,0,0,0"  # straight down, the upper border of the image ahead
            poses.append(f"{stamp},0.5,{along},{rest},0.002,0.003,0.002,0.001,0.001,0.001,0.1")
            truth.append(f"{stamp},0.501,{along},{rest}")
            states.append(f"{stamp},tracking")
            offsets += [f"{stamp},A,0,0,0", f"{stamp},B,0.012,0.001,1"]
            commands.append(f"{stamp},0.25,0,0,0,0,0")
            if k % 5 == 0:
                images.append(f"{stamp},images/{k}.pgm")
                self.write(f"f/rack/images/{k}.pgm", "P5\n60 40\n255\n" + 60 * 40 * "p")
        for name, lines in {"pose": poses, "truth": truth, "state": states, "offsets": offsets,
                            "command": commands, "images": images}.items():
            self.write(f"f/rack/{name}.csv", "\n".join(lines) + "\n")
        self.write("f/rack/way_points.csv", "stamp,done,of,message\n1000.400000000,1,1,\"1 of 1\"\n")
        self.write("f/rack/rack.yaml",
                   "row:\n  - {name: A, radius: 0.15, length: 10}\n"
                   "  - {name: B, radius: 0.15, length: 10, gap: 0.1}\n")
        self.write("f/rack/camera.yaml",
                   "image_width: 60\nimage_height: 40\n"
                   "camera_matrix: {data: [50, 0, 30, 0, 50, 20, 0, 0, 1]}\n"
                   "distortion_coefficients: {data: [0, 0, 0, 0, 0]}\n")
        self.write("f/mission.yaml",
                   "components:\n  - {type: 'pipescout::VisualServo', name: visual_servo,\n"
                   "     parameters: {way_points: [0.5, 2.2, 1.5, 1.57]}}\n")

    def test_draws_all_pictures_of_a_flight(self):
        out, err = self.plot("rack", "f")
        self.assertEqual(err, "")
        self.assertEqual(paths(out), [f"f/pictures/{name}" for name in (
            "overlay.svg", "map.svg", "flight.svg", "pose_errors.svg", "offsets.svg", "animation.gif")])
        overlay = self.read("f/pictures/overlay.svg")
        self.assertTrue(overlay.startswith(b"<?xml"))
        self.assertIn(b"model at the estimated pose", overlay)
        self.assertTrue(self.read("f/pictures/animation.gif").startswith(b"GIF89a"))

    def test_draws_the_rest_of_a_flight_with_a_broken_file_and_one_that_is_missing(self):
        self.write("f/rack/rack.yaml", "row:\n  - {name: A, radius: wide, length: 10}\n")
        (self.folder / "f/rack/truth.csv").unlink()
        out, err = self.plot("rack", "f", code=1)
        self.assertEqual(paths(out), ["f/pictures/flight.svg", "f/pictures/offsets.svg"])
        self.assertIn("rack.yaml: line 2: 'radius' is not a finite number", err)
        self.assertIn("not drawn: pose_errors: no truth.csv", err)

    def test_only_a_missing_file_is_no_error(self):
        (self.folder / "f/rack/images.csv").unlink()
        out, err = self.plot("rack", "f", "--format", "png", "--out", "p")
        self.assertEqual(paths(out), ["p/map.png", "p/flight.png", "p/pose_errors.png", "p/offsets.png"])
        self.assertIn("not drawn: overlay: no images.csv", err)


class WithoutDrawing(PlotCommand):
    def test_names_the_package_of_a_missing_python(self):
        self.python = str(self.folder / "no_python")
        _, err = self.plot("odometry", "m", code=1)
        self.assertIn("no_python: No such file", err)
        self.assertIn("Debian package python3,", err)

    def test_names_the_package_of_a_missing_matplotlib(self):
        # Without the folders of installed packages.
        self.write("python", f"#!/bin/sh\nexec {PYTHON} -S \"$@\"\n")
        python = self.folder / "python"
        python.chmod(python.stat().st_mode | stat.S_IXUSR)
        self.python = str(python)
        _, err = self.plot("odometry", "m", code=1)
        self.assertIn("install the Debian packages python3-matplotlib, python3-numpy", err)

    def test_refuses_a_wrong_command_line_without_matplotlib(self):
        self.write("python", f"#!/bin/sh\nexec {PYTHON} -S \"$@\"\n")
        python = self.folder / "python"
        python.chmod(python.stat().st_mode | stat.S_IXUSR)
        self.python = str(python)
        self.plot(code=2)
        self.plot("odometry", code=2)
        self.plot("odometry", "m", "--format", "jpg", code=2)
        self.plot("rack", "m", "--alignment", "a.csv", code=2)
        _, err = self.plot("odometri", "m", code=2)
        self.assertIn("odometry", err)
        out, _ = self.plot("--help")
        self.assertIn("flights over a pipe rack", out)


if __name__ == "__main__":
    unittest.main()
