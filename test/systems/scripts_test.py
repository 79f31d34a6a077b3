#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs launch_scripts/inspect.sh, setup.sh and build_product.sh, test/run.sh and test/sanitize.sh as a user does, in
a copy of the project that holds the scripts only: nothing is installed or built there.

    scripts_test.py CASE PROJECT SCRATCH
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys

# Takes the place of colcon: two packages, of which `one` has tests; one of them is an executable of
# three Google tests.
COLCON = r'''#!/usr/bin/env bash
base=build
for ((i = 1; i <= $#; ++i)); do
  if [ "${!i}" = --build-base ]; then
    following=$((i + 1)) base=${!following}
  fi
done
echo "colcon $*" >>"$COLCON_LOG"
case " $* " in
  *" list "*) printf 'one\ntwo\n' ;;
  *" build "*)
    printf 'Starting >>> %s\nFinished <<< %s [1.0s]\n' one one
    if [ -n "${FAKE_BUILD_FAILURE:-}" ]; then
      mkdir -p log/latest_build/two
      echo "two.cpp:1: error: no such thing" >log/latest_build/two/stdout_stderr.log
      printf 'Starting >>> two\nFailed   <<< two [1.0s, exited with code 2]\n'
      exit 2
    fi
    printf 'Starting >>> %s\nFinished <<< %s [1.0s]\n' two two
    mkdir -p "$base/one" "$base/two" "$base/../install" install
    touch "$base/../install/local_setup.bash" "$base/two/CTestTestfile.cmake"
    if [ -z "${FAKE_UNBUILT:-}" ]; then
      cat >"$base/one/CTestTestfile.cmake" <<END
add_test(plain "${FAKE_PLAIN:-true}")
add_test(google bash "-c" "${FAKE_GOOGLE:-$PWD/google_tests} $PWD/$base/one/test_results/google.xml")
END
    fi ;;
esac
'''
GOOGLE_TESTS = r'''#!/usr/bin/env bash
failure='<failure message="f">1 is not 2</failure>'
mkdir -p "$(dirname "$1")"
cat >"$1" <<END
<testsuites><testsuite name="A">
<testcase name="passes" status="run" classname="A"/>
<testcase name="fails" status="run" classname="A">${FAKE_FAILURE:+$failure}</testcase>
<testcase name="skips" status="run" classname="A"><skipped message="s"/></testcase>
</testsuite></testsuites>
END
[ -z "${FAKE_FAILURE:-}" ] && [ -z "${FAKE_CRASH:-}" ]
'''
# Takes the place of apt-get where one of two missing packages needs a newer libc6.
APT_GET = '''#!/usr/bin/env bash
case " $* " in
  *" update "*) echo "noise of the lists"; echo "dlstatus:1:50.0:Retrieving" >&3 ;;
  *" -s "*) printf 'Inst libc6 [2.36-9] (2.36-10 Debian:12 [amd64])\\nInst make (4.3 Debian:12 [amd64])\\n' ;;
  *" --assume-no "*) printf 'Need to get 12 MB of archives.\\nAfter this operation, 40 MB of additional disk.\\n'; exit 1 ;;
  *" install "*)
    echo "Unpacking noise"
    printf 'pmstatus:make:%s:x\\n' 30.0 100.0 >&3
    [ -z "${FAKE_FAILURE:-}" ] || { echo "E: no space left"; exit 100; } ;;
esac
'''
# Takes the place of pipescout where only what it is asked matters.
PIPESCOUT = '''#!/usr/bin/env bash
printf '%s\\n' "ROS_LOCALHOST_ONLY=${ROS_LOCALHOST_ONLY:-}" "$@"
'''
WRONG_COMMAND_LINES = [
    (["--nothing"], "unknown option '--nothing'"),
    (["missing.csv"], "no file 'missing.csv'"),
    (["own.csv", "own.csv"], "one file of readings only"),
    (["--sigma"], "--sigma: a value is missing"),
    (["--sigma", "0.1,x"], "--sigma: 'x' is not a number"),
    (["--sigma="], "--sigma: no numbers"),
    (["--offsets", "0.1,,0.2"], "--offsets: '' is not a number"),
    (["--epsilon", "half"], "--epsilon: 'half' is not a number"),
    (["--period=1s"], "--period: '1s' is not a number"),
    (["--rate", "nan"], "--rate: 'nan' is not a number"),
    (["own.csv"], "--sigma A,B,... is missing"),
    (["--reference", "paper"], "--reference goes with a file of your own readings"),
]


class Project:
    """A copy of the scripts, as if all packages were installed and built."""

    def __init__(self, origin, folder):
        self.origin, self.folder = origin, folder
        folder.mkdir()
        shutil.copytree(origin / "launch_scripts", folder / "launch_scripts")
        (folder / "test").mkdir()
        for script in (*(origin / "test").glob("*.sh"), origin / "test/results.py"):
            shutil.copy(script, folder / "test")
        self.program("launch_scripts/setup.sh", "#!/usr/bin/env bash\n")
        self.program("test/interoperability/bag_readers/install.sh", "#!/usr/bin/env bash\n")
        self.program("programs/colcon", COLCON)
        self.program("google_tests", GOOGLE_TESTS)
        for name in ("idl", "interfaces", "src", "components", "install"):
            (folder / name).mkdir()
        (folder / "colcon.meta").touch()
        (folder / "install/local_setup.bash").touch()
        (folder / "install/.inspect_built").touch()

    def program(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)

    def run(self, *command, code=0, folder=None, **variables):
        """What the script says; its exit code must be `code`."""
        environment = dict(os.environ, COLCON_LOG=str(self.folder / "colcon.log"))
        environment.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
        environment["PATH"] = f"{self.folder / 'programs'}:{environment['PATH']}"
        environment.pop("ROS_LOCALHOST_ONLY", None)
        environment.update(variables)
        result = subprocess.run([*map(str, command)], cwd=folder or self.folder, env=environment,
                                timeout=800, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                text=True)
        print("$", *command, "\n" + result.stdout)
        assert result.returncode == code, f"exit code {result.returncode}, not {code}"
        return result.stdout

    def colcon_calls(self):
        log = self.folder / "colcon.log"
        return log.read_text() if log.exists() else ""


def expect_in(text, *parts):
    for part in parts:
        assert part in text, f"no {part!r}"


def inspect_command_line(project):
    project.program("programs/pipescout", PIPESCOUT)
    (project.folder / "own.csv").write_text("a,b\n1,1\n")
    inspect = "launch_scripts/inspect.sh"
    expect_in(project.run(inspect, "--help"), "--sigma A,B,...", "Exit code: 0")
    for arguments, reason in WRONG_COMMAND_LINES:
        expect_in(project.run(inspect, *arguments, code=2), f"inspect.sh: {reason}",
                  "inspect.sh --help")
    told = project.run(inspect, "own.csv", "--sigma", "1, .5,2e-2", "--offsets=-1,+2,3.0",
                       "--epsilon=.8", "--weighting", "paper_equation_13", "--period", "2",
                       "--rate=10", "--reference", "truth", "--out", "a mission")
    expect_in(told, f"\nrun\n{project.folder}/launch_scripts/own_readings.yaml\n",
              f"\nreadings:='{project.folder}/own.csv'\n",
              f"\nreference_file:='{project.folder}/own.csv'\n", "\nreference_column:=truth\n",
              "\nodometer_replay.standard_deviations:=[1.0, .5, 2e-2]\n",
              "\nodometry_fusion.offsets:=[-1.0, +2.0, 3.0]\n", "\nodometry_fusion.epsilon:=.8\n",
              "\nodometry_fusion.weighting:='paper_equation_13'\n", "\nodometer_replay.period:=2.0\n",
              "\nodometer_replay.rate:=10.0\n", "\n--out\na mission\n")


def inspect_environment(project):
    project.program("programs/pipescout", PIPESCOUT)
    inspect = "launch_scripts/inspect.sh"
    expect_in(project.run(inspect), "\nROS_LOCALHOST_ONLY=1\n")
    expect_in(project.run(inspect, ROS_LOCALHOST_ONLY="0"), "\nROS_LOCALHOST_ONLY=0\n")
    # With CDPATH, cd finds other folders and prints where it went.
    (project.folder / "elsewhere/launch_scripts").mkdir(parents=True)
    expect_in(project.run(inspect, CDPATH=str(project.folder / "elsewhere")),
              f"\n{project.folder}/launch_scripts/odometry.yaml\n")


def inspect_builds_what_changed(project):
    project.program("programs/pipescout", PIPESCOUT)
    inspect = "launch_scripts/inspect.sh"
    expect_in(project.run(inspect), "Nothing has changed since the last build.")
    assert "build" not in project.colcon_calls()
    built = (project.folder / "install/.inspect_built").stat().st_mtime_ns
    source = project.folder / "src/new.cpp"
    source.touch()
    os.utime(source, ns=(built + 10**9, built + 10**9))
    project.run(inspect)
    expect_in(project.colcon_calls(), "colcon build")


def build_shows_progress(project):
    build = "launch_scripts/build_product.sh"
    told = project.run(build)
    expect_in(told, "1 of 2 packages", "Built 2 packages in 0 min")
    expect_in(project.colcon_calls(), "--base-paths idl interfaces src components")
    assert "Finished" not in told and "Starting" not in told, told
    expect_in(project.run(build, code=2, FAKE_BUILD_FAILURE="1"), "Failed   <<< two",
              "two is not built; the end of", "two.cpp:1: error: no such thing")
    assert project.run(build, "--list") == "one\ntwo\n"


def setup_is_quiet(project):
    shutil.copy(project.origin / "launch_scripts/setup.sh", project.folder / "launch_scripts/setup.sh")
    (project.folder / "launch_scripts/apt-packages.txt").write_text("# Build\nmake\ng++\ngit\n")
    project.program("programs/dpkg-query", "#!/usr/bin/env bash\necho git installed\n")
    project.program("programs/apt-get", APT_GET)
    project.program("programs/sudo", '#!/usr/bin/env bash\nexec "$@"\n')
    setup = "launch_scripts/setup.sh"
    told = project.run(setup)
    expect_in(told, "2 of 3 packages are missing: make g++\n", " 50 % downloading\n", "  libc6 2.36-9 -> 2.36-10\n",
              "Installing 2 packages and what they need, 1 in all (12 MB to download, 40 MB on disk)\n",
              " 30 % installing make\n", "Installed 2 packages.\n")
    assert told.index("libc6") < told.index("Installing"), "what is upgraded is named before"
    assert "noise" not in told, told
    log, = (project.folder / "log").glob("setup_*.log")
    expect_in(log.read_text(), "noise of the lists", "Unpacking noise", "Inst libc6")
    log.unlink()
    expect_in(project.run(setup, code=1, FAKE_FAILURE="1"), "not everything could be installed; the end of",
              "E: no space left")


def inspect_paper(project):
    told = project.run("launch_scripts/inspect.sh", "--out", "mission", "--rate", "10")
    expect_in(told, "Complete: 10 of 10 readings recorded, 10 fused distances.",
              f"mission folder: {project.folder}/mission")
    summary = json.loads((project.folder / "mission/summary.json").read_text())
    assert summary["figures"]["odometry_readings"] == 10, summary
    # A folder is that of one mission.
    project.run("launch_scripts/inspect.sh", "--out", "mission", code=1)


def inspect_hostile_paths(project):
    """Blanks, what YAML takes for a comment, and a name that YAML takes for no text."""
    folder = project.folder / "my data: #1"
    folder.mkdir()
    (folder / "it's #2.csv").write_text("a,b,true\n1,1.01,1\n2,2.01,2\n")
    told = project.run(project.folder / "launch_scripts/inspect.sh", "it's #2.csv",
                       "--sigma", "0.1,0.1", "--reference", "true", "--rate", "10", "--out",
                       "out #3", folder=folder)
    expect_in(told, "Complete: 2 of 2 readings recorded", "true [m]")
    assert (folder / "out #3/odometry/fused.csv").is_file()


def inspect_bad_readings(project):
    (project.folder / "bad.csv").write_text("a,b\n1,one\n")
    expect_in(project.run("launch_scripts/inspect.sh", "bad.csv", "--sigma", "0.1,0.1", code=1),
              "bad.csv:2: column 'b': 'one' is not a number")
    expect_in(project.run("launch_scripts/inspect.sh", "--epsilon", "5", code=1), "epsilon")


def run_counts_tests(project):
    run = "test/run.sh"
    expect_in(project.run(run), "\n3 passed, 0 failed, 1 skipped\n")
    expect_in(project.run(run, "one"), "\n3 passed, 0 failed, 1 skipped\n")
    expect_in(project.run(run, FAKE_PLAIN="false", code=1), "\n- plain\n",
              "\n2 passed, 1 failed, 1 skipped\n")
    expect_in(project.run(run, FAKE_FAILURE="1", code=1), "1 is not 2", "\n- google A.fails\n",
              "\n2 passed, 1 failed, 1 skipped\n")
    # All its tests passed, and yet it failed; it left no results; it could not be started.
    expect_in(project.run(run, FAKE_CRASH="1", code=1), "\n- google\n",
              "\n3 passed, 1 failed, 1 skipped\n")
    expect_in(project.run(run, FAKE_GOOGLE="false", code=1), "\n- google\n",
              "\n1 passed, 1 failed, 0 skipped\n")
    expect_in(project.run(run, FAKE_PLAIN="/missing/program", code=1), "\n- plain\n",
              "\n2 passed, 1 failed, 1 skipped\n")
    expect_in(project.run(run, FAKE_PLAIN="false", FAKE_FAILURE="1", code=1), "\n- plain\n",
              "\n1 passed, 2 failed, 1 skipped\n")


def run_misses_tests(project):
    run = "test/run.sh"
    shutil.rmtree(project.folder / "build", ignore_errors=True)
    expect_in(project.run(run, FAKE_UNBUILT="1", code=1), "not built: one\n", "no test ran")
    expect_in(project.run(run, "two", code=1), "no test ran", "\n0 passed, 0 failed, 0 skipped\n")


def sanitize_judges_tests(project):
    sanitize = "test/sanitize.sh"
    expect_in(project.run(sanitize), "address: nothing found", "thread: nothing found")
    expect_in(project.run(sanitize, "thread", FAKE_CRASH="1", code=1), "thread: FAILED")
    expect_in(project.run(sanitize, "address", "one", FAKE_PLAIN="false", code=1),
              "address: FAILED")


def misspelt_packages(project):
    for command in (["test/run.sh"], ["test/sanitize.sh"], ["test/sanitize.sh", "address"]):
        expect_in(project.run(*command, "one", "tow", code=2), "no package 'tow'", "one\ntwo")
    calls = project.colcon_calls()
    assert " build " not in calls and " test " not in calls, calls


def main():
    case, origin, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    cases = {function.__name__: function for function in (
        inspect_command_line, inspect_environment, inspect_builds_what_changed, build_shows_progress,
        setup_is_quiet, inspect_paper, inspect_hostile_paths, inspect_bad_readings, run_counts_tests, run_misses_tests,
        sanitize_judges_tests, misspelt_packages)}
    cases[case](Project(origin.resolve(), scratch.resolve() / "project"))


if __name__ == "__main__":
    main()
