#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Installs packages as ROS 2 does, with the .idl files that its own rosidl makes, and has `pipescout`
read them at run time: from .msg, .srv and .action as from .idl alone it must see what it is built with.

    foreign_types_test.py SCRATCH
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

PYTHON = "/usr/bin/python3"  # whatever other Python comes first on the search path
PACKAGES = ["geometry_msgs", "sensor_msgs", "std_srvs", "nav2_msgs", "visualization_msgs",
            "rcl_interfaces", "pipescout_msgs"]


def run(*command, **environment):
    result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, check=False,
                            env={**os.environ, **environment})
    assert result.returncode == 0, f"{' '.join(map(str, command))}\n{result.stderr}"
    return result.stdout


def install(folder, package, prefix, idl_only):
    """What `ament_cmake` and rosidl install of a package's definitions."""
    arguments = prefix / "adapter.json"
    prefix.mkdir(parents=True, exist_ok=True)
    files = sorted(path.relative_to(folder) for kind in ("msg", "srv", "action")
                   for path in (folder / kind).glob("*"))
    arguments.write_text(json.dumps({"non_idl_tuples": [f"{folder}:{file}" for file in files]}))
    share = prefix / "share" / package
    share.mkdir(parents=True)
    run(PYTHON, "-m", "rosidl_adapter", "--package-name", package, "--arguments-file", arguments,
        "--output-dir", share, "--output-file", prefix / "adapted.txt")
    listed = [file.with_suffix(".idl") for file in files]
    if not idl_only:
        for file in files:
            shutil.copy(folder / file, share / file)
        listed += files
    for file in files:
        if file.suffix == ".srv":
            listed += [file.with_name(f"{file.stem}_{half}.msg") for half in ("Request", "Response")]
    index = prefix / "share/ament_index/resource_index/rosidl_interfaces"
    index.mkdir(parents=True, exist_ok=True)
    (index / package).write_text("".join(f"{file}\n" for file in sorted(listed)))
    return files


def shown(name, **environment):
    return run("pipescout", "interface", "show", name, "--no-comments", **environment)


def main():
    scratch = pathlib.Path(sys.argv[1])
    shutil.rmtree(scratch, ignore_errors=True)
    count = 0
    for form in ("text", "idl"):
        prefix = scratch / form
        environment = {"AMENT_PREFIX_PATH": f"{prefix}:{os.environ.get('AMENT_PREFIX_PATH', '')}"}
        for package in PACKAGES:
            # Under a name that `pipescout` does not have.
            foreign = f"foreign_{package}"
            run("pipescout", "interface", "export", package, "--ros2", scratch / "export")
            folder = scratch / "export" / package
            files = install(folder, foreign, prefix, form == "idl")
            listed = run("pipescout", "interface", "package", foreign, **environment).split()
            names = sorted(f"{foreign}/{file.with_suffix('')}" for file in files)
            assert listed == names, (listed, names)
            for name in names:
                own = name.removeprefix("foreign_")
                # Types of its own package are written without it.
                loaded = re.sub(r"\bforeign_", "", shown(name, **environment))
                assert loaded == shown(own), f"{name} from {form}:\n{loaded}\nnot\n{shown(own)}"
                count += 1
    assert count >= 2 * 100, count
    print(f"{count} definitions are read as they are built in")


if __name__ == "__main__":
    main()
