# SPDX-License-Identifier: Apache-2.0
"""What tests of missions share: running `pipescout` as a user does, and reading what it recorded."""

import csv
import json
import os
import re
import subprocess

# What a mission is there to tell of: findings, and what its odometers do wrong by design of the simulation.
FINDINGS = re.compile(
    r"leak \d+ raised: "
    r"|odometer '\w+': (slipping|stuck|worn|bad values|silent)$"
    r"|the distance of odometer '\w+' is not a finite number"
    r"|no group of odometers agrees"
    r"|weld spacing (shows that the fused odometer was wrong|differs from the tally) by ")


def environment():
    result = dict(os.environ, ROS_LOCALHOST_ONLY="1")
    result.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    return result


def warnings(told):
    """Lines of the log that a healthy mission does not have."""
    lines = [line for line in told.splitlines() if re.match(r"\[(WARN|ERROR|FATAL)\]", line)]
    return [line for line in lines if not FINDINGS.search(line)]


def expect_healthy(told):
    """Whoever runs a mission for the first time has no other way to know that all is well."""
    unexpected = warnings(told)
    assert not unexpected, f"a healthy mission warned: {unexpected}"


def pipescout(*arguments, timeout):
    try:
        result = subprocess.run(["pipescout", *map(str, arguments)], env=environment(),
                                timeout=timeout, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                text=True)
    except subprocess.TimeoutExpired as expired:
        print((expired.stdout or b"").decode(errors="replace"))  # bytes, whatever was asked for
        raise
    print(result.stdout)
    assert result.returncode == 0, f"exit code {result.returncode}"
    return result.stdout


def recorded(folder, name):
    files = list(folder.rglob(name))
    assert len(files) == 1, files
    with files[0].open(newline="") as file:
        return list(csv.DictReader(file))


def figures(folder, prefix):
    """Those of the mission's summary whose name begins with the prefix, without it."""
    found = json.loads((folder / "summary.json").read_text())["figures"]
    return {name[len(prefix):]: value for name, value in found.items() if name.startswith(prefix)}
