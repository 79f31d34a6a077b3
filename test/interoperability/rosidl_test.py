#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Gives all definitions, and the packages that `pipescout interface export` writes, to ROS 2's own
rosidl: its parser reads them, its generator writes C++, a compiler takes that.

    rosidl_test.py DEFINITIONS SCRATCH

DEFINITIONS holds a folder per package, with msg, srv and action in it.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

# Of Debian's packages, whatever other Python comes first on the search path.
PYTHON = "/usr/bin/python3"
GENERATOR = "/usr/libexec/rosidl/rosidl_generator_cpp"
TEMPLATES = "/usr/share/rosidl_generator_cpp/resource"
INCLUDE = ["/usr/include/rosidl_runtime_c", "/usr/include/rosidl_runtime_cpp",
           "/usr/include/rosidl_typesupport_interface"]


def definitions(package):
    """Paths relative to the package, without what an adapted .msg has a twin for."""
    found = {}
    for path in sorted(package.glob("*/*")):
        if path.suffix in (".msg", ".srv", ".action", ".idl"):
            found.setdefault(path.with_suffix(""), path)
    return [path.relative_to(package) for path in found.values()]


def run(*command):
    result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True, check=False)
    assert result.returncode == 0, f"{' '.join(map(str, command))}\n{result.stdout}"


def adapted(package, scratch):
    """(folder, path) of an .idl for each definition: as it stands, or as rosidl's adapter makes it."""
    made = []
    for path in definitions(package):
        if path.suffix == ".idl":
            made.append((package, path))
            continue
        arguments = scratch / "adapter.json"
        arguments.write_text(json.dumps({"non_idl_tuples": [f"{package}:{path}"]}))
        out = scratch / "adapted" / package.name
        out.mkdir(parents=True, exist_ok=True)
        run(PYTHON, "-m", "rosidl_adapter", "--package-name", package.name, "--arguments-file",
            arguments, "--output-dir", out, "--output-file", scratch / "adapted.txt")
        made.append((out, path.with_suffix(".idl")))
    return made


def generate(package, scratch):
    """Headers of one package; returns those that a user includes."""
    idls = adapted(package, scratch)
    out = scratch / "include" / package.name
    arguments = scratch / "generator.json"
    arguments.write_text(json.dumps({
        "package_name": package.name, "output_dir": str(out), "template_dir": TEMPLATES,
        "idl_tuples": [f"{folder}:{path}" for folder, path in idls], "target_dependencies": []}))
    run(PYTHON, GENERATOR, "--generator-arguments-file", arguments)
    visibility = out / "msg" / "rosidl_generator_cpp__visibility_control.hpp"
    visibility.parent.mkdir(parents=True, exist_ok=True)
    macro = f"ROSIDL_GENERATOR_CPP_PUBLIC_{package.name}"
    visibility.write_text(f"#pragma once\n#define {macro}\n")
    headers = sorted(path.relative_to(scratch / "include") for kind in ("msg", "srv", "action")
                     for path in (out / kind).glob("*.hpp") if path != visibility)
    assert len(headers) == len(idls), (package, len(headers), len(idls))
    return headers


def compile_all(headers, scratch):
    program = scratch / "all.cpp"
    program.write_text("".join(f'#include "{header}"\n' for header in headers) + "int main() {}\n")
    run("g++", "-std=c++17", "-fsyntax-only", "-w", f"-I{scratch / 'include'}",
        *[f"-I{folder}" for folder in INCLUDE], program)


def exported(name, scratch):
    """The package as a ROS 2 workspace gets it."""
    run("pipescout", "interface", "export", name, "--ros2", scratch / "export")
    return scratch / "export" / name


def main():
    folder, scratch = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    if not os.access(GENERATOR, os.X_OK):
        sys.exit(f"{GENERATOR} is missing: launch_scripts/setup.sh installs it")
    shutil.rmtree(scratch, ignore_errors=True)
    packages = sorted({path.parent.parent for path in folder.glob("*/*/*")
                       if path.parent.name in ("msg", "srv", "action")})
    assert "pipescout_msgs" in [package.name for package in packages], packages
    for form in ("as they stand", "exported"):
        with tempfile.TemporaryDirectory() as own:
            headers = []
            for package in packages:
                if form == "exported":
                    package = exported(package.name, scratch)
                headers += generate(package, pathlib.Path(own))
            compile_all(headers, pathlib.Path(own))
            print(f"{len(packages)} packages, {len(headers)} definitions {form}: "
                  "rosidl's C++ compiles")


if __name__ == "__main__":
    main()
