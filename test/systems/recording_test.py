#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Recordings on the network: what is counted, what is there at the start, and what never changes.

    recording_test.py CASE SCRATCH

counts: the recorder's last line is what is in the bag; a recording that got nothing fails and says why
play_waits: with --wait a subscription that is there hears every message from the first on
read_only: no command that reads a bag changes its folder, whatever state the bag is in
"""

import os
import pathlib
import re
import shutil
import signal
import sqlite3
import sys

from mission import pipescout
from replay_test import TIMEOUT, Background, counts

MESSAGES = 40


def record(bag, *options, topic="/words"):
    """The recorder's log of a recording that SIGINT ended; it heard MESSAGES at least."""
    recorder = Background("bag", "record", "-o", bag, topic, *options)
    talker = Background("topic", "pub", "-r", 200, topic, "std_msgs/msg/String", "{data: hello}")
    recorder.await_error_line(f"recording '{topic}'")
    pipescout("topic", "echo", "-n", MESSAGES, topic, timeout=TIMEOUT)
    recorder.process.send_signal(signal.SIGINT)
    _, log = recorder.process.communicate(timeout=TIMEOUT)
    assert recorder.process.returncode == 0, log
    talker.stop(128 + signal.SIGINT)
    return log


def count_cases(scratch):
    for k, options in enumerate(([], ["-s", "mcap"], ["-b", "86016"],
                                 ["-s", "mcap", "--compression-mode", "file"])):
        bag = scratch / f"bag_{k}"
        log = record(bag, *options)
        said = re.search(r"(\d+) messages of 1 topics recorded", log)
        assert said, log
        in_bag = int(re.search(r"Messages: +(\d+)", pipescout("bag", "info", bag, timeout=TIMEOUT))[1])
        assert int(said[1]) == in_bag > 0, (log, in_bag)
        pipescout("bag", "check", bag, timeout=TIMEOUT)

    # A publisher that says nothing.
    player = Background("bag", "play", scratch / "bag_0", "--start-paused")
    silent = Background("bag", "record", "-o", scratch / "nothing", "/nobody", "/words")
    silent.await_error_line("recording '/words'")
    silent.process.send_signal(signal.SIGINT)
    _, said = silent.process.communicate(timeout=TIMEOUT)
    player.stop()
    print(said)
    assert silent.process.returncode == 1, silent.process.returncode
    assert "no message was recorded: asked for topic /nobody, /words" in said, said
    assert "no message came on /words; published were " in said, said
    assert "/rosout" in said, said


def play_waits(scratch):
    bag = scratch / "bag"
    record(bag)
    total = counts(bag)["/words"]
    listener = Background("topic", "echo", "--csv", "-n", total, "/words", "std_msgs/msg/String")
    while "Subscription count: 1" not in pipescout("topic", "info", "/words", timeout=TIMEOUT):
        pass  # it is not there yet
    pipescout("bag", "play", bag, "--wait", timeout=TIMEOUT)
    heard, said = listener.process.communicate(timeout=TIMEOUT)
    assert heard.split() == ["hello"] * total, (len(heard.split()), total, said)


def leave_wal(file):
    """As a writer in WAL mode that was killed leaves a database."""
    child = os.fork()
    if child == 0:
        database = sqlite3.connect(file)
        database.execute("PRAGMA journal_mode=WAL")
        database.execute("INSERT INTO messages(topic_id, timestamp, data) "
                         "SELECT topic_id, timestamp + 1, data FROM messages")
        database.commit()
        os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(child, 0)
    assert pathlib.Path(f"{file}-wal").stat().st_size > 0


def state(folder):
    return {file.name: (file.read_bytes(), file.stat().st_mtime_ns)
            for file in sorted(folder.iterdir())}


def read_only(scratch):
    plain, wal, mcap = (scratch / name for name in ("plain", "wal", "mcap"))
    record(plain)
    shutil.copytree(plain, wal)
    (wal / "plain_0.db3").rename(wal / "wal_0.db3")
    leave_wal(wal / "wal_0.db3")
    pipescout("bag", "reindex", wal, timeout=TIMEOUT)
    pipescout("bag", "convert", plain, "-o", mcap, "-s", "mcap", timeout=TIMEOUT)
    for bag in (plain, wal, mcap):
        before = state(bag)
        out = scratch / f"out_{bag.name}"
        for command in (["bag", "info", bag], ["bag", "check", bag],
                        ["bag", "convert", bag, "-o", f"{out}_converted"],
                        ["bag", "filter", bag, "-o", f"{out}_filtered", "--topics", "/words"],
                        ["bag", "merge", bag, "-o", f"{out}_merged"],
                        ["bag", "recover", bag, "-o", f"{out}_recovered"],
                        ["bag", "export", bag, "-o", f"{out}_exported", "--csv"],
                        ["bag", "play", bag, "--rate", "1000"],
                        ["summary", bag, "--json", f"{out}.json"]):
            pipescout(*command, timeout=TIMEOUT)
            assert state(bag) == before, f"{command} has changed {bag}"
        exported = (pathlib.Path(f"{out}_exported") / "words.csv").read_text().splitlines()
        expected = counts(plain)["/words"] * (2 if bag == wal else 1)
        assert len(exported) == expected + 1, (bag, len(exported), expected)


if __name__ == "__main__":
    os.environ["ROS_LOCALHOST_ONLY"] = "1"
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    scratch_folder = pathlib.Path(sys.argv[2])
    shutil.rmtree(scratch_folder, ignore_errors=True)
    scratch_folder.mkdir(parents=True)
    {"counts": count_cases, "play_waits": play_waits,
     "read_only": read_only}[sys.argv[1]](scratch_folder)
