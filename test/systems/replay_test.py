#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Records, plays and replays as a user does.

    replay_test.py CASE SCRATCH

identical: a crawler's mission is recorded, and replayed into fusion and locator: the same bytes each time
without_clock: the same of a bag without /clock, whose time is that of its messages
across_processes: record, play and echo in three processes; bags that do not go with a composition
"""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys

from mission import pipescout

TIMEOUT = 300  # s, of a run

RECORD = """name: recorded
arguments: {{tally: $(share pipescout_crawler_simulation)/tally.csv}}
components:
  - type: pipescout::BagRecorder
    name: bag_recorder
    parameters:
      output: $(mission_folder)/bag
      storage: mcap
      all: true
      exclude: '{exclude}'
      use_sim_time: true
      repeatable: true
  - type: pipescout::CrawlerSimulation
    name: crawler_simulation
    parameters:
      tally: $(arg tally)
      route: $(share pipescout_crawler_simulation)/route.csv
      seed: 7
      rate: 200.0
      start_joint: 11
      length: 60.0
      wheels: [wheel_1, wheel_2, wheel_3]
      periods: [0.02, 0.025, 0.05]
      peak_snr: 18.0
      imu_rate: 50.0
      wait_for_subscribers.readings: [bag_recorder]
      wait_for_subscribers.eddy_current: [bag_recorder]
complete_when: [crawler_simulation]
"""

REPLAY = """name: replayed
components:
  - type: pipescout::OdometerStreamFusion
    name: odometry_fusion
    parameters:
      odometers: [wheel_1, wheel_2, wheel_3]
      sigmas_per_sqrt_metre: [0.004, 0.004, 0.004]
      maximum_age: 5.0
  - type: pipescout::WeldLocator
    name: weld_locator
    parameters:
      tally: $(share pipescout_crawler_simulation)/tally.csv
      maximum_age: 5.0
"""


def counts(bag):
    """Messages of each topic, as metadata.yaml says."""
    text = (bag / "metadata.yaml").read_text()
    return {name: int(count) for name, count in
            re.findall(r"name: (/\S+)\n.*?message_count: (\d+)", text, re.DOTALL)}


def content(folder):
    return {file.name: file.read_bytes() for file in sorted(folder.iterdir())}


def record(scratch, exclude):
    composition = scratch / "record.yaml"
    composition.write_text(RECORD.format(exclude=exclude))
    pipescout("run", composition, "--namespace", "/", "--out", scratch / "mission", timeout=TIMEOUT)
    return scratch / "mission" / "bag"


def replay_several_times(scratch, bag):
    composition = scratch / "replay.yaml"
    composition.write_text(REPLAY)
    outputs = []
    # As fast as it goes, twice, and at a pace at which the machine's time would tell.
    for name, more in (("first", []), ("second", []), ("paced", ["--rate", "100"])):
        out = scratch / name / "out"
        out.parent.mkdir()
        pipescout("run", composition, "--bag", bag, "--record", out, "--out", scratch / name / "m",
                  *more, timeout=TIMEOUT)
        outputs.append(content(out))
    first = counts(scratch / "first" / "out")
    print(first)
    assert first["/odometer/fused"] > 2000 and first["/pipe/position"] > 2000, first
    assert first["/weld"] >= 3, first
    assert "/eddy_current" not in first, first  # an input
    assert outputs[0] == outputs[1], "two replays differ"
    assert outputs[0] == outputs[2], "a replay at a pace differs"


def identical(scratch):
    bag = record(scratch, "^/(rosout|diagnostics)$")
    recorded = counts(bag)
    assert recorded["/clock"] > 5000 and recorded["/odometer/readings"] > 15000, recorded
    replay_several_times(scratch, bag)


def without_clock(scratch):
    bag = record(scratch, "/(clock|rosout|diagnostics|imu|ground_truth)")
    assert "/clock" not in counts(bag), counts(bag)
    replay_several_times(scratch, bag)


class Background:
    """A command that runs until it is told to stop."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen(["pipescout", *map(str, arguments)], stderr=subprocess.PIPE,
                                        stdout=subprocess.PIPE, text=True)

    def await_error_line(self, part):
        seen = ""
        for line in self.process.stderr:
            seen += line
            if part in line:
                return
        raise AssertionError(f"'{part}' was not said: {seen}")

    def stop(self, code=0):
        self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=TIMEOUT)
        assert self.process.returncode == code, (self.process.returncode, err)
        return out


def refusal(*arguments):
    result = subprocess.run(["pipescout", *map(str, arguments)], timeout=TIMEOUT,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(result.stdout)
    assert result.returncode != 0
    return result.stdout


def record_words(bag, topic):
    recorder = Background("bag", "record", "-o", bag, topic)
    talker = Background("topic", "pub", "-r", 50, topic, "std_msgs/msg/String", "{data: hello}")
    recorder.await_error_line(f"recording '{topic}'")
    pipescout("topic", "echo", "-n", 10, topic, timeout=TIMEOUT)
    recorder.stop()
    talker.stop(128 + signal.SIGINT)


def across_processes(scratch):
    os.environ["ROS_LOCALHOST_ONLY"] = "1"
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    bag = scratch / "words"
    record_words(bag, "/words")
    assert counts(bag)["/words"] > 0
    player = Background("bag", "play", bag, "--loop", "--rate", 10, "--remap", "/words:=/again")
    heard = pipescout("topic", "echo", "--csv", "-n", 5, "/again", "std_msgs/msg/String",
                      timeout=TIMEOUT)
    player.stop()
    assert heard.split() == ["hello"] * 5, heard
    pipescout("bag", "play", bag, "--rate", 1000, timeout=TIMEOUT)

    composition = scratch / "replay.yaml"
    composition.write_text(REPLAY)
    said = refusal("run", composition, "--bag", bag, "--out", scratch / "m1")
    assert "has no topic that the composition subscribes to" in said
    wrong = scratch / "wrong"
    record_words(wrong, "/eddy_current")
    said = refusal("run", composition, "--bag", wrong, "--out", scratch / "m2")
    assert "eddy_current" in said and "pipescout_msgs/msg/EddyCurrentSamples" in said, said
    assert str(scratch / "nowhere") in refusal("run", composition, "--bag", scratch / "nowhere")
    assert "--bag" in refusal("run", composition, "--record", scratch / "x")
    assert "Must specify" in refusal("bag", "record")


if __name__ == "__main__":
    scratch_folder = pathlib.Path(sys.argv[2])
    shutil.rmtree(scratch_folder, ignore_errors=True)
    scratch_folder.mkdir(parents=True)
    {"identical": identical, "without_clock": without_clock,
     "across_processes": across_processes}[sys.argv[1]](scratch_folder)
