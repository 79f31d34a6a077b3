# SPDX-License-Identifier: Apache-2.0
"""What tests of missions share: running `pipescout` as a user does, and reading what it recorded."""

import csv
import json
import os
import subprocess


def pipescout(*arguments, timeout):
    environment = dict(os.environ, ROS_LOCALHOST_ONLY="1")
    environment.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    try:
        result = subprocess.run(["pipescout", *map(str, arguments)], env=environment,
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
