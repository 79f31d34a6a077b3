#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a clean build of the project without tests costs: CPU time, all processes together.

Builds in a folder of its own that is removed afterwards, without ccache. Other work on the machine
makes the build longer, and the CPU time somewhat: give it an idle machine.
"""
import argparse
import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
FOLDERS = ["idl", "interfaces", "src", "components"]
SLOWEST = 10  # files that are named
MOST_BUILD_CPU = 1200.0  # s
MOST_FILE_CPU = 12.0  # s


def seconds(text):
    """Of the shell's `times`: 1m2.5s"""
    minutes, rest = re.fullmatch(r"(\d+)m([\d.]+)s", text).groups()
    return 60 * int(minutes) + float(rest)


def file_times(log):
    """CPU seconds by object file, the slowest first; names relative to the build folder."""
    times = []
    for line in log.read_text().splitlines():
        user, system, name = line.split(" ", 2)
        times.append((seconds(user) + seconds(system), name))
    return sorted(times, reverse=True)


def short_name(name, build):
    """pipescout_geometry/src/so3.cpp of build/pipescout_geometry/CMakeFiles/.../src/so3.cpp.o"""
    name = os.path.relpath(name, build)
    return re.sub(r"CMakeFiles/[^/]*\.dir/", "", name).removesuffix(".o")


def build(scratch, packages):
    """CPU seconds of the whole build, and (CPU seconds, name) of its files."""
    log = scratch / "compile_times"
    log.touch()
    environment = dict(os.environ, COMPILE_TIMES=str(log), CCACHE_DISABLE="1")
    environment["CMAKE_C_COMPILER_LAUNCHER"] = str(HERE / "compile_timer.sh")
    environment["CMAKE_CXX_COMPILER_LAUNCHER"] = str(HERE / "compile_timer.sh")
    # What is installed from an earlier build must not be found in place of what is built here.
    for variable in ("CMAKE_PREFIX_PATH", "COLCON_PREFIX_PATH", "AMENT_PREFIX_PATH"):
        environment.pop(variable, None)
    base_paths = [str(ROOT / folder) for folder in FOLDERS if (ROOT / folder).is_dir()]
    colcon = ["colcon", "--log-base", str(scratch / "log"), "build",
              "--base-paths", *base_paths,
              "--build-base", str(scratch / "build"), "--install-base", str(scratch / "install"),
              "--event-handlers", "console_start_end-", "console_direct-",
              *(["--packages-up-to", *packages] if packages else []),
              "--cmake-args", "-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF"]
    command = f'. {ROOT}/launch_scripts/build_environment.sh && exec "$@"'
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(["bash", "-c", command, "build", *colcon], cwd=ROOT, env=environment,
                   stdout=sys.stderr, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return cpu, [(time, short_name(name, scratch / "build")) for time, name in file_times(log)]


def print_figure(name, value, target):
    met = "met" if value <= target else "NOT MET"
    print(f"{name:<32}{value:12.3f}   at most  {target:8.3f}   {met}")


def main():
    parser = argparse.ArgumentParser(prog="test/benchmark/run.sh build", description=__doc__)
    parser.add_argument("--json", metavar="FILE", help="writes figures and rows to FILE")
    parser.add_argument("--packages-up-to", nargs="+", default=[], metavar="PACKAGE",
                        help="only these and what they need, in place of the whole project")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="pipescout_build_") as scratch:
        try:
            cpu, files = build(pathlib.Path(scratch), options.packages_up_to)
        except subprocess.CalledProcessError as error:
            sys.exit(f"the build failed ({error.returncode})")
    rows = [{"case": name, "cpu_s": round(time, 3)} for time, name in files]
    for row in rows[:SLOWEST]:
        print(f"{row['case']:<72}{row['cpu_s']:8.3f} s")
    largest = files[0][0] if files else 0.0
    print()
    print_figure("build_cpu_seconds", cpu, MOST_BUILD_CPU)
    print_figure("largest_file_cpu_s", largest, MOST_FILE_CPU)
    if options.json:
        figures = {"build_cpu_seconds": cpu, "largest_file_cpu_s": largest}
        document = {"figures": figures, "rows": rows, "seeds": []}
        pathlib.Path(options.json).write_text(json.dumps(document, indent=2) + "\n")


if __name__ == "__main__":
    main()
