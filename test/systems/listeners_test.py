#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Flies and drives missions alone and in company, and compares what they left behind: nobody who
listens, and no load of the machine, changes a result.

    listeners_test.py MISSION LAUNCH_SCRIPTS SCRATCH
"""

import contextlib
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import threading

from mission import pipescout

TIMEOUT = 600  # s, of a run
ARGUMENTS = {
    "crawler": ["--param", "crawler_simulation.length:=150.0", "rate:=1000.0"],
    "rack": ["--param", "visual_servo.way_points:=[0.9, 4.0, 2.6, 1.5707963]", "duration:=40.0",
             "rate:=1000.0"],
    "patrol": ["--param", "patrol_simulation.row.length:=10.0",
               "--param", "patrol_simulation.leaks:=[4.0, 0.3, 80.0]",
               "--param", "patrol_simulation.plant.leak_rows:=[1]",
               "--param", "patrol_simulation.plant.tour:=[0]",
               "--param", "patrol_simulation.plant.start:=[-4.0, 6.75, 0.0]",
               "--param", "patrol_simulation.plant.obstacles:=[]", "rate:=1000.0"],
}
BUSY_LOOPS = 4
# Of the wall clock, or of the run's place.
NOT_COMPARED = re.compile(r"mission\.(log|yaml)|summary\.json|metadata\.yaml|.*\.(sqlite|db|db3|html|mcap)")


def environment():
    return dict(os.environ, ROS_LOCALHOST_ONLY="1",
                ROS_DOMAIN_ID=os.environ.get("ROS_DOMAIN_ID", str(1 + os.getpid() % 100)))


@contextlib.contextmanager
def running(command, ready=None):
    """A process beside the mission; `ready` is the line after which it does its work."""
    process = subprocess.Popen(command, env=environment(), stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True)
    try:
        if ready:
            for line in process.stdout:
                if ready in line:
                    break
        yield process
    finally:
        process.send_signal(signal.SIGCONT)
        process.terminate()
        process.communicate()


@contextlib.contextmanager
def alone(_scratch):
    yield


@contextlib.contextmanager
def recorder(scratch):
    """Of all topics, in another process."""
    bag = scratch / "bag"
    with running(["pipescout", "bag", "record", "-a", "-o", str(bag)], ready="the bag is"):
        yield
    assert bag.exists(), "nothing was recorded"


@contextlib.contextmanager
def busy_machine(_scratch):
    with contextlib.ExitStack() as stack:
        for _ in range(BUSY_LOOPS):
            stack.enter_context(running([sys.executable, "-c", "while True: pass"]))
        yield


@contextlib.contextmanager
def stopped_reader(_scratch):
    """Of the topic with the most messages; stops within the mission."""
    with running(["pipescout", "topic", "echo", "/imu/data", "sensor_msgs/msg/Imu"]) as process:
        def stop_after_first_message():
            stopped.append(process.stdout.readline())
            process.send_signal(signal.SIGSTOP)

        stopped = []
        watch = threading.Thread(target=stop_after_first_message)
        watch.start()
        yield
        watch.join()
        assert stopped[0], "nothing was heard"


def results(folder):
    return {str(file.relative_to(folder)): file.read_bytes()
            for file in sorted(folder.rglob("*"))
            if file.is_file() and not NOT_COMPARED.fullmatch(file.name)}


def main():
    mission, launch_scripts, scratch = sys.argv[1], *map(pathlib.Path, sys.argv[2:4])
    shutil.rmtree(scratch, ignore_errors=True)
    expected = None
    for company in (alone, recorder, busy_machine, stopped_reader):
        own = scratch / company.__name__
        own.mkdir(parents=True)
        with company(own):
            pipescout("run", launch_scripts / f"{mission}.yaml", "--out", own / "mission",
                      *ARGUMENTS[mission], timeout=TIMEOUT)
        found = results(own / "mission")
        assert found, "the mission left nothing behind"
        expected = expected or found
        assert found.keys() == expected.keys(), (sorted(found), sorted(expected))
        different = [name for name in found if found[name] != expected[name]]
        assert not different, f"{company.__name__}: {different} differ from those of the run alone"
        print(f"{company.__name__}: {len(found)} files, the same bytes", flush=True)


if __name__ == "__main__":
    main()
