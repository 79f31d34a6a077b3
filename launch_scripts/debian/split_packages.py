#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Divides an install tree among the Debian packages: split_packages.py TREE BUILD STAGE PACKAGE...

TREE is an install folder of colcon, BUILD the folder with its install manifests, one per package of the
workspace. PACKAGE... are packed, and what they need. Each file goes to
STAGE/PACKAGE/usr/...: of a workspace package that `pipescout` itself needs to pipescout-runtime, of
components and what they need to pipescout-components, of subcommands and what they need to
pipescout-tools; headers and what CMake needs of all of them to pipescout-dev.
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
            needs = {element.text for element in tree
                     if element.tag in ("buildtool_depend", "depend", "exec_depend")}
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


def is_elf(file):
    with open(file, "rb") as stream:
        return stream.read(4) == b"\x7fELF"


def finish(files, script):
    """Without symbols, and without search paths: those of the build are of no use elsewhere, and in
    /usr/lib the linker looks anyway."""
    subprocess.run(["strip", "--strip-unneeded", *map(str, files)], check=True)
    script.write_text("".join(f'file(RPATH_REMOVE FILE "{file}")\n' for file in files))
    subprocess.run(["cmake", "-P", str(script)], check=True)
    script.unlink()


def main():
    tree, build, stage = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    packages = workspace()
    manifests = {file.parent.name: file for file in build.glob("*/install_manifest.txt")
                 if file.parent.name in packages}
    wanted = closure(packages, sys.argv[4:])
    missing = wanted - set(manifests)
    if missing:
        sys.exit(f"error: {build}: not built: {', '.join(sorted(missing))}; "
                 "launch_scripts/build_product.sh builds them")
    manifests = {name: file for name, file in manifests.items() if name in wanted}
    taken, elves = {}, []
    for name, debian in sorted(owners(packages, set(manifests)).items()):
        for line in manifests[name].read_text().splitlines():
            path = pathlib.Path(line).relative_to(tree)
            if path.parts[0] == name:  # a prefix for each package
                path = path.relative_to(name)
            if path.parts[:2] == ("share", name) and len(path.parts) > 2 and \
                    path.parts[2] in ("environment", "hook") and name not in BUILD_ONLY:
                # For a workspace; what stands in /usr is found without. Those of pipescout_cmake are
                # copied into the workspaces of others.
                continue
            owner = "pipescout-dev" if is_for_developers(path) else debian
            if taken.setdefault(path, owner) != owner:
                sys.exit(f"error: {path}: of {taken[path]} and of {owner}")
            target = stage / owner / "usr" / path
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(line, target, follow_symlinks=False)
            if not target.is_symlink() and is_elf(target):
                elves.append(target)
    finish(elves, stage / "remove_rpath.cmake")


if __name__ == "__main__":
    main()
