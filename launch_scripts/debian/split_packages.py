#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Divides an install tree among the Debian packages: split_packages.py TREE BUILD STAGE

TREE is a merged install of colcon, BUILD the folder with its install manifests, one per package.
Each file goes to STAGE/PACKAGE/usr/...: of a workspace package that `pipescout` itself needs to
pipescout-runtime, of components and what they need to pipescout-components, of subcommands and what
they need to pipescout-tools; headers and what CMake needs of all of them to pipescout-dev.
"""
import pathlib
import shutil
import subprocess
import sys
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FOLDERS = ("idl", "interfaces", "src", "components")
BUILD_ONLY = {"pipescout_cmake", "pipescout_testing"}  # of use to those who build


def workspace():
    """{package: (folder, packages that it needs)}"""
    found = {}
    for folder in FOLDERS:
        for file in (ROOT / folder).rglob("package.xml"):
            if any(part in ("test", "build", "install") for part in file.relative_to(ROOT).parts):
                continue
            tree = xml.etree.ElementTree.parse(file).getroot()
            needs = {element.text for element in tree if element.tag in ("depend", "exec_depend")}
            found[tree.findtext("name")] = (str(file.parent.relative_to(ROOT)), needs)
    return found


def closure(packages, roots):
    reached, open_ = set(), list(roots)
    while open_:
        package = open_.pop()
        if package in packages and package not in reached:
            reached.add(package)
            open_.extend(packages[package][1])
    return reached


def owners(packages, built):
    """{workspace package: Debian package}"""
    components = {name for name in built if packages[name][0].startswith("components/")}
    tools = {name for name in components if packages[name][0].startswith("components/tools/")}
    result = {}
    for debian, roots in (("pipescout-runtime", {"pipescout_host"}),
                          ("pipescout-components", components - tools - {"pipescout_host"}),
                          ("pipescout-tools", tools), ("pipescout-dev", built)):
        for name in closure(packages, roots & built) & built:
            if name in BUILD_ONLY:
                result[name] = "pipescout-dev"
            result.setdefault(name, debian)
    return result


def is_for_developers(path):
    return (path.parts[0] == "include" or "cmake" in path.parts or path.suffix in (".a", ".hpp") or
            path.name == "package.xml")


def strip(file):
    with open(file, "rb") as stream:
        if stream.read(4) == b"\x7fELF":
            subprocess.run(["strip", "--strip-unneeded", str(file)], check=True)


def main():
    tree, build, stage = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    packages = workspace()
    manifests = {file.parent.name: file for file in build.glob("*/install_manifest.txt")}
    unknown = set(manifests) - set(packages)
    if unknown:
        sys.exit(f"error: {build}: no package.xml of {', '.join(sorted(unknown))}")
    taken = {}
    for name, debian in sorted(owners(packages, set(manifests)).items()):
        for line in manifests[name].read_text().splitlines():
            path = pathlib.Path(line).relative_to(tree)
            if path.parts[:2] == ("share", name) and len(path.parts) > 2 and \
                    path.parts[2] in ("environment", "hook"):
                continue  # for a workspace; what stands in /usr is found without
            owner = "pipescout-dev" if is_for_developers(path) else debian
            if taken.setdefault(path, owner) != owner:
                sys.exit(f"error: {path}: of {taken[path]} and of {owner}")
            target = stage / owner / "usr" / path
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(tree / path, target, follow_symlinks=False)
            if not target.is_symlink():
                strip(target)


if __name__ == "__main__":
    main()
