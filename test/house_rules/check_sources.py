#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the rules of the house on the tracked sources; prints each breach and exits 1 if there is one.

    check_sources.py [RULE...]     only these rules; --list names them
"""

import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
CPP = {".cpp", ".hpp", ".h", ".c", ".in"}

# The only place that knows Fast DDS. The benchmark's peer is a plain Fast DDS program on purpose.
FAST_DDS_PLACES = ("interfaces/dds/src/", "interfaces/dds/test/", "test/benchmark/plain_fastdds/")
FAST_DDS = re.compile(r'#\s*include\s*[<"](fastdds|fastrtps|fastcdr)/')
FAST_CDR_PLACES = ("idl/",)


def tracked():
    """Files that git knows or would add, relative to the root; all files outside a checkout."""
    try:
        listing = subprocess.run(
            ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\n")
        names = [name for name in listing if name]
    except (OSError, subprocess.CalledProcessError):
        skip = {"build", "install", "log", ".git"}
        names = [str(path.relative_to(ROOT)) for path in ROOT.rglob("*")
                 if path.is_file() and path.relative_to(ROOT).parts[0] not in skip]
    return sorted(name for name in set(names) if (ROOT / name).is_file())


def sources(under=""):
    return [name for name in tracked()
            if name.startswith(under) and pathlib.Path(name).suffix in CPP]


def read(name):
    return (ROOT / name).read_text(encoding="utf-8", errors="replace")


def algorithms_reach_no_middleware():
    """What src/ includes is no middleware, and of ours only what lies in src/ itself."""
    forbidden = re.compile(
        r"(^|/)(fastdds|fastrtps|fastcdr|class_loader|spdlog)/|_msgs/|"
        r"(^|/)(builtin_interfaces|rcl_interfaces)/")
    # Through headers of the same folder nothing else is reached; other libraries do not know it.
    own = {path.name for path in (ROOT / "src").glob("**/include/pipescout/*")}
    for name in sources("src/"):
        if name.startswith("src/storage/"):
            continue  # Some still take settings and times from the runtime.
        for number, line in enumerate(read(name).splitlines(), 1):
            found = re.match(r'\s*#\s*include\s*(?:[<"]([^>"]+)[>"])?', line)
            if not found:
                continue
            header = found.group(1)
            if header is None:
                yield f"{name}:{number}: includes what a macro says"
            elif forbidden.search(header) or (
                    header.startswith("pipescout/") and header.split("/")[1] not in own):
                yield f"{name}:{number}: includes {header}"


def fast_dds_in_one_place():
    """Fast DDS headers are included only in interfaces/dds."""
    for name in sources():
        if name.startswith(FAST_DDS_PLACES):
            continue
        for number, line in enumerate(read(name).splitlines(), 1):
            found = FAST_DDS.search(line)
            if found and not (found.group(1) == "fastcdr" and name.startswith(FAST_CDR_PLACES)):
                yield f"{name}:{number}: includes {found.group(1)}"


def files_stay_small():
    """No file grows past 800 lines."""
    for name in tracked():
        if pathlib.Path(name).suffix in CPP | {".py", ".sh", ".cmake", ".md"}:
            lines = read(name).count("\n")
            if lines > 800:
                yield f"{name}: {lines} lines"


def randomness_is_seeded():
    """No random_device, rand or Eigen Random."""
    pattern = re.compile(r"random_device|(?<![\w:.])s?rand\(|Eigen::\w+(<[^>]*>)?::Random\(")
    for name in sources():
        for number, line in enumerate(read(name).splitlines(), 1):
            if pattern.search(line):
                yield f"{name}:{number}: {line.strip()}"


def tests_do_not_sleep():
    """Tests wait for events; where there is none, a comment above says "No event: why"."""
    pattern = re.compile(r"sleep_for|sleep_until|\bu?sleep\(|(^|\s)sleep [0-9]")
    for name in tracked():
        if "test/" not in name or pathlib.Path(name).suffix not in CPP | {".sh"}:
            continue
        before = ""
        for number, line in enumerate(read(name).splitlines(), 1):
            if pattern.search(line) and "// No event: " not in before:
                yield f"{name}:{number}: {line.strip()}"
            before = line


def nothing_is_left_open():
    """No reminders in what is delivered."""
    pattern = re.compile(r"\b(TODO|FIXME|XXX)\b")
    for name in tracked():
        if name == "test/house_rules/check_sources.py":
            continue
        if pathlib.Path(name).suffix in CPP | {".py", ".sh", ".md", ".cmake", ".txt", ".yaml"}:
            for number, line in enumerate(read(name).splitlines(), 1):
                if pattern.search(line):
                    yield f"{name}:{number}: {line.strip()}"


def sources_carry_the_licence():
    """Each source begins with its SPDX line."""
    for name in sources():
        if "SPDX-License-Identifier: Apache-2.0" not in "\n".join(read(name).splitlines()[:3]):
            if pathlib.Path(name).suffix != ".in":
                yield f"{name}: no SPDX line"


def packages_declare_what_they_use():
    """Each find_package(pipescout_*) is declared in package.xml; dependencies run one way."""
    rank = {"idl": 0, "interfaces": 2, "src": 1, "storage": 1, "components": 3, "docs": 4, "test": 4}

    def room_of(name):
        return "storage" if name.startswith("src/storage/") else pathlib.Path(name).parts[0]

    where = {}
    manifests = [name for name in tracked() if pathlib.Path(name).name == "package.xml"]
    trees = {}
    for name in manifests:
        tree = ElementTree.fromstring(read(name))
        trees[name] = tree
        where[tree.findtext("name")] = room_of(name)
    for name, tree in trees.items():
        folder = str(pathlib.Path(name).parent)
        room = room_of(name)
        if tree.findtext("export/build_type") != "cmake":
            yield f"{name}: build_type is not cmake"
        if tree.findtext("license") != "Apache-2.0":
            yield f"{name}: the licence is not Apache-2.0"
        declared = {element.text for element in tree if element.tag.endswith("depend")}
        used = set()
        for cmake in [f for f in tracked() if f.startswith(folder + "/") and
                      pathlib.Path(f).name == "CMakeLists.txt"]:
            # A fixture below a test folder is a project of its own.
            if "/test/" in cmake[len(folder):] and "project(" in read(cmake):
                continue
            used |= set(re.findall(r"find_package\(\s*(pipescout_\w+)", read(cmake)))
            # Tests name targets; the packages of those that are not known yet are found by their names.
            for call in re.findall(r"pipescout_add_tests\(([^()]*)", read(cmake)):
                used |= {f"pipescout_{target}" for target in re.findall(r"pipescout::(\w+)", call)
                         if f"pipescout_{target}" in where}
        used.discard(tree.findtext("name"))
        for package in sorted(used - declared):
            yield f"{name}: {package} is used but not declared"
        for package in sorted(d for d in declared if d in where and room != "storage"):
            theirs = where[package]
            if package == "pipescout_cmake":
                continue  # all build with it
            if rank[theirs] > rank[room] or (room in {"src", "idl"} and theirs in {"interfaces", "idl"}):
                yield f"{name}: {room} must not depend on {package} in {theirs}"


def formatting():
    """clang-format has nothing to change."""
    names = [name for name in sources() if pathlib.Path(name).suffix != ".in"]
    result = subprocess.run(["clang-format", "--dry-run", "-Werror", *names], cwd=ROOT,
                            capture_output=True, text=True)
    if result.returncode != 0:
        for line in result.stderr.splitlines():
            if "error:" in line:
                yield line


def no_private_places():
    """No path or host of one machine is committed."""
    # Written in pieces so that this file does not match itself.
    pattern = re.compile("/ho" r"me/\w+/|/wo" "rk/|http" r"s?://(localhost|127|10\.|192\.168)|/ro" "ot/")
    for name in tracked():
        if pathlib.Path(name).suffix in {".png", ".svg", ".csv"}:
            continue
        for number, line in enumerate(read(name).splitlines(), 1):
            if pattern.search(line):
                yield f"{name}:{number}: {line.strip()[:120]}"


RULES = [
    algorithms_reach_no_middleware, fast_dds_in_one_place, files_stay_small, randomness_is_seeded,
    tests_do_not_sleep, nothing_is_left_open, sources_carry_the_licence,
    packages_declare_what_they_use, formatting, no_private_places,
]


def main(arguments):
    rules = {rule.__name__: rule for rule in RULES}
    if arguments == ["--list"]:
        print("\n".join(f"{name}: {rule.__doc__}" for name, rule in rules.items()))
        return 0
    unknown = [name for name in arguments if name not in rules]
    if unknown:
        print(f"unknown rules: {', '.join(unknown)}; --list names them", file=sys.stderr)
        return 2
    breaches = 0
    for name in arguments or rules:
        for breach in rules[name]():
            print(f"{name}: {breach}")
            breaches += 1
    print(f"{len(arguments or rules)} rules checked, {breaches} breaches")
    return 1 if breaches else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
