#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads the ament index of what is installed by the rules of ament_index_python and ros2cli (Humble).

Run with the environment of the workspace (install/setup.bash).
"""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

INDEX = "share/ament_index/resource_index"


def prefixes():
    """The search path, as ament_index_python takes it: folders that exist, the first one wins."""
    return [path for path in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
            if path and os.path.exists(path)]


def resources(kind):
    """Name -> prefix. Names that begin with a dot and folders are no resources."""
    found = {}
    for prefix in prefixes():
        folder = pathlib.Path(prefix, INDEX, kind)
        for entry in sorted(folder.iterdir()) if folder.is_dir() else []:
            if not entry.is_dir() and not entry.name.startswith("."):
                found.setdefault(entry.name, pathlib.Path(prefix))
    return found


def resource(kind, name):
    """Content and prefix."""
    prefix = resources(kind)[name]
    return pathlib.Path(prefix, INDEX, kind, name).read_text(encoding="utf-8"), prefix


def executables(package):
    """Names that `ros2 run` finds."""
    folder = resources("packages")[package] / "lib" / package
    return {file.name: file for file in folder.glob("**/*") if os.access(file, os.X_OK)}


class InstalledIndex(unittest.TestCase):
    def test_packages_of_the_workspace_are_found(self):
        packages = resources("packages")
        for name in ("pipescout_cmake", "pipescout_idl", "pipescout_runtime", "pipescout_odometry",
                     "pipescout_odometry_fusion", "pipescout_host", "pipescout_msgs"):
            self.assertIn(name, packages)

    def test_manifest_has_the_name_of_the_package(self):
        for name, prefix in resources("packages").items():
            if name.startswith("pipescout"):
                root = ElementTree.parse(prefix / "share" / name / "package.xml").getroot()
                self.assertEqual(root.findtext("name"), name)

    def test_packages_of_ros_are_left_to_ros(self):
        for name in ("std_msgs", "sensor_msgs", "rcl_interfaces"):
            prefix = resources("packages").get(name)
            self.assertFalse(prefix and (prefix / "share/pipescout_idl").exists(), name)

    def test_component_types_have_their_libraries(self):
        content, prefix = resource("rclcpp_components", "pipescout_odometry_fusion")
        self.assertEqual(content, resource("pipescout_components", "pipescout_odometry_fusion")[0])
        self.assertIn("pipescout::OdometryFusion", [line.split(";")[0] for line in content.splitlines()])
        for line in content.splitlines():
            parts = line.split(";")
            self.assertEqual(len(parts), 2, line)
            self.assertTrue((prefix / parts[1]).is_file(), line)

    def test_executable_runs_from_where_ros2_run_finds_it(self):
        program = executables("pipescout_host")["pipescout"]
        version = subprocess.run([program, "--version"], check=True, capture_output=True, text=True)
        self.assertRegex(version.stdout, r"^\d+\.\d+\.\d+")

    def test_interfaces_are_listed_and_there(self):
        content, prefix = resource("rosidl_interfaces", "pipescout_msgs")
        names = content.splitlines()
        self.assertIn("msg/LeakEvent.msg", names)
        self.assertIn("msg/LeakEvent.idl", names)
        for name in names:
            self.assertTrue((prefix / "share/pipescout_msgs" / name).is_file(), name)

    def test_interface_show_can_read_each_line(self):
        """`ros2 interface show` parses each line of a .msg file alone: a comment, a constant, a field."""
        identifier = r"[A-Za-z][A-Za-z0-9_]*"
        line = re.compile(
            rf"^({identifier}(/{identifier})?(<=\d+)?(\[(<=)?\d*\])? {identifier}(=.*| [^#]*)?)?\s*(#.*)?$")
        content, prefix = resource("rosidl_interfaces", "pipescout_msgs")
        for name in content.splitlines():
            if not name.endswith(".idl"):
                text = (prefix / "share/pipescout_msgs" / name).read_text(encoding="utf-8")
                for each in text.splitlines():
                    if each != "---":
                        self.assertRegex(each, line, name)

    def test_comments_are_kept(self):
        prefix = resources("packages")["pipescout_msgs"]
        text = (prefix / "share/pipescout_msgs/msg/RackState.msg").read_text(encoding="utf-8")
        self.assertIn("# What the rack localizer makes of one image", text)
        self.assertIn("float64[] offset_variance  # m^2", text)


class EnvironmentHook(unittest.TestCase):
    """Two packages, of which one names the hook, built by colcon in each layout."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="pipescout ament "))
        self.addCleanup(shutil.rmtree, self.folder)
        for name in ("first", "second"):
            package = self.folder / "src" / name
            package.mkdir(parents=True)
            (package / "package.xml").write_text(
                f"<package format='3'><name>{name}</name><version>0.1.0</version><description>-</description>"
                "<maintainer email='a@b.org'>a</maintainer><license>Apache-2.0</license>"
                "<export><build_type>cmake</build_type></export></package>")
            (package / "CMakeLists.txt").write_text(
                f"cmake_minimum_required(VERSION 3.22)\nproject({name} LANGUAGES NONE)\n"
                "find_package(pipescout_cmake REQUIRED)\npipescout_index_package()\n")
        (self.folder / "src/first/colcon.pkg").write_text(
            '{"hooks": ["share/first/environment/ament_prefix_path.sh"]}')

    def search_path(self, *options):
        subprocess.run(["colcon", "--log-base", "log", "build", "--event-handlers", "console_direct-",
                        *options], cwd=self.folder, check=True, capture_output=True)
        result = {}
        for shell in ("sh", "bash"):
            # Twice: a path that is there already is not added again.
            script = f". install/local_setup.{shell}; . install/local_setup.{shell}; echo \"$AMENT_PREFIX_PATH\""
            run = subprocess.run([shell, "-c", script], cwd=self.folder, check=True, capture_output=True,
                                 text=True, env={**os.environ, "AMENT_PREFIX_PATH": "/before"})
            result[shell] = run.stdout.strip().split(os.pathsep)
        self.assertEqual(result["sh"], result["bash"])
        return result["sh"]

    def test_merged(self):
        install = str(self.folder / "install")
        self.assertEqual(self.search_path("--merge-install"), [install, "/before"])

    def test_isolated(self):
        install = self.folder / "install"
        self.assertCountEqual(self.search_path(), [str(install / "first"), str(install / "second"), "/before"])


if __name__ == "__main__":
    unittest.main()
