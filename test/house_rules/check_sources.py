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

# Where a package may stand.
SUBJECTS = "recording|in_pipe|rack|leaks|arm|estimation|navigation|simulators|tools"
PLACES = (
    r"idl(/\w+)?", r"interfaces/(runtime|dds|testing)", r"interfaces/catalogue/\w+",
    r"src/(?!navigation$|storage$|studies$)\w+", r"src/(navigation|storage|studies)/\w+",
    r"components/host", rf"components/({SUBJECTS})/\w+", r"test/\w+", r"docs/\w+",
)
# The kinds of packages, by folder, and the kinds whose packages each may use.
INTERFACES = {"interfaces/runtime", "interfaces/dds", "interfaces/catalogue", "interfaces/testing"}
MAY_USE = {
    "idl": {"idl"},
    "interfaces/runtime": {"idl", "src/storage"},
    "interfaces/dds": {"idl", "interfaces/runtime", "src/storage"},
    "interfaces/testing": {"idl", "interfaces/runtime"},
    "interfaces/catalogue": {"idl", "interfaces/runtime", "interfaces/catalogue", "src", "src/storage"},
    "src": {"src"},
    "src/storage": {"src", "src/storage"},
    "src/studies": {"src", "src/storage", "src/studies"},
    # No component links another: its classes would be registered under the wrong library.
    "components": {"idl", "interfaces/runtime", "interfaces/catalogue", "src", "src/storage"},
    "components/host": {"idl", *INTERFACES, "src/storage", "components/tools"},
    "components/tools": {"idl", *INTERFACES, "src", "src/storage", "src/studies", "components/tools"},
}
MAY_USE |= {anything: {"docs", "test", *MAY_USE} for anything in ("docs", "test")}
KINDS = set(MAY_USE)
# The settings that all packages share are made of CMake alone.
for kind in KINDS:
    MAY_USE[kind] = MAY_USE[kind] | {"src/cmake"}
MAY_USE["src/cmake"] = set()
KINDS.add("src/cmake")
MAY_USE_IN_TESTS = {
    kind: {"src", "src/storage", "src/studies"} if kind.startswith("src") else
          {"idl", *INTERFACES, "src/storage"} if kind.startswith("interfaces") else
          {*INTERFACES, "src", "src/storage", "src/studies"}
    for kind in KINDS
}
# What a robot carries in any domain: nothing that these link is an algorithm.
WITHOUT_ALGORITHMS = ("interfaces/runtime", "interfaces/dds", "interfaces/testing",
                      "interfaces/catalogue/topics", "components/host",
                      "components/tools/command_line")


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


def kind_of(name):
    """The kind of package that a file belongs to: the longest folder of KINDS that it lies in."""
    return max((kind for kind in KINDS if name.startswith(kind + "/")), key=len, default=None)


def packages():
    """Of each package.xml: its folder and what it says."""
    for name in tracked():
        if pathlib.Path(name).name == "package.xml":
            yield name, str(pathlib.Path(name).parent), ElementTree.fromstring(read(name))


def packages_stand_where_their_kind_is():
    """Each folder says what kind of thing it holds, and a package stands in one of them."""
    known = {"idl", "interfaces", "src", "components", "launch_scripts", "test", "docs"}
    for top in sorted({name.split("/")[0] for name in tracked() if "/" in name}):
        if top not in known and not top.startswith("."):
            yield f"{top}: the top level holds {', '.join(sorted(known))}"
    folders = {folder for _, folder, _ in packages()}
    for folder in sorted(folders):
        if not any(re.fullmatch(place, folder) for place in PLACES):
            yield f"{folder}: no place for a package; see docs/packages.md"
        for other in folders:
            if folder.startswith(other + "/") and not folder.startswith("idl/"):
                yield f"{folder}: lies in the package {other}, where colcon does not look"


def includes_run_one_way():
    """Sources include headers of their own kind of package and of those that it may depend on."""
    forbidden = re.compile(
        r"(^|/)(fastdds|fastrtps|fastcdr|class_loader|spdlog)/|_msgs/|"
        r"(^|/)(builtin_interfaces|rcl_interfaces)/")
    provider = {}  # part of an include path below pipescout/ -> folder of the package, its kind
    for _, folder, _ in packages():
        for path in (ROOT / folder / "include" / "pipescout").glob("*"):
            provider[path.name] = (folder, kind_of(folder + "/"))
    for name in sources():
        kind = kind_of(name)
        if kind is None:
            continue
        may = MAY_USE[kind] | (MAY_USE_IN_TESTS[kind] if "/test/" in name else set())
        for number, line in enumerate(read(name).splitlines(), 1):
            found = re.match(r'\s*#\s*include\s*(?:[<"]([^>"]+)[>"])?', line)
            if not found:
                continue
            header = found.group(1)
            if header is None:
                if kind.startswith("src"):
                    yield f"{name}:{number}: includes what a macro says"
                continue
            if kind.startswith("src") and forbidden.search(header):
                yield f"{name}:{number}: includes {header}"
            if header.startswith("pipescout/"):
                folder, theirs = provider.get(header.split("/")[1], ("", None))
                if not name.startswith(folder + "/") and theirs not in may:
                    yield f"{name}:{number}: {kind} must not include {header}"


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


def libraries_do_not_ask_the_locale():
    """Libraries read and write numbers without the locale that their program may have set."""
    # Programs of the project set none; what a user's program links does.
    libraries = re.compile(r"(src/|interfaces/(?!testing/)|components/(?!tools/|host/))(?!.*/(test|example|testing)/)")
    asks = re.compile(r"\b(strto(d|f|ld)|std::sto(d|f|ld)|atof|sscanf)\s*\(|\.as<(double|float)>"
                      r'|printf\([^;]*"[^"]*%[-+0-9.*]*[aefgAEFG]')
    stream = re.compile(r"\bstd::[io]?stringstream (\w+)[;({]")
    for name in sources():
        if not libraries.match(name):
            continue
        text = read(name)
        for match in asks.finditer(text):
            yield f"{name}:{text.count(chr(10), 0, match.start()) + 1}: {match.group(0).split(chr(10))[0]}"
        for match in stream.finditer(text):
            shifts_numbers = re.search(rf"\b{match.group(1)}\b\s*(<<|>>)(?!\s*\w+\.rdbuf)", text)
            if shifts_numbers and f"{match.group(1)}.imbue(" not in text:
                yield (f"{name}:{text.count(chr(10), 0, match.start()) + 1}: stream "
                       f"'{match.group(1)}' has the global locale; imbue std::locale::classic()")


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
    """Each find_package(pipescout_*) is declared in package.xml, with build type and licence."""
    ours = {tree.findtext("name") for _, _, tree in packages()}
    for name, folder, tree in packages():
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
                         if f"pipescout_{target}" in ours}
        used.discard(tree.findtext("name"))
        for package in sorted(used - declared):
            yield f"{name}: {package} is used but not declared"


def dependencies_run_one_way():
    """idl <- interfaces <- components -> src; components link no other; the runtime knows no algorithm."""
    kinds = {tree.findtext("name"): kind_of(folder + "/") for _, folder, tree in packages()}
    linked = {}
    for name, folder, tree in packages():
        own = tree.findtext("name")
        kind = kinds[own]
        linked[own] = {e.text for e in tree if e.tag in ("depend", "build_depend")} & set(kinds)
        for element in tree:
            theirs = kinds.get(element.text)
            if theirs is None or element.tag in ("exec_depend", "name"):
                continue
            may = set(MAY_USE[kind])
            if element.tag == "test_depend":
                may |= MAY_USE_IN_TESTS[kind]
            if theirs not in may:
                yield f"{name}: {kind} must not depend on {element.text} in {theirs}"
    for name, folder, tree in packages():
        if folder not in WITHOUT_ALGORITHMS:
            continue
        reached, ahead = set(), {tree.findtext("name")}
        while ahead:
            reached |= ahead
            ahead = set().union(*(linked[package] for package in ahead)) - reached
        for package in sorted(p for p in reached if kinds[p] in ("src", "src/studies")):
            yield f"{name}: needs the algorithms of {package}"


def packages_are_described():
    """docs/packages.md names the folder of each package, and no other."""
    described = set(re.findall(r"^\| `([^`]+)`", read("docs/packages.md"), re.MULTILINE))
    folders = {folder for _, folder, _ in packages()}
    for folder in sorted(folders ^ described):
        yield f"docs/packages.md: {folder} is {'missing' if folder in folders else 'no package'}"


def pages_show_tested_code():
    """A class or a main function on a page of docs/ stands, word by word, in the package of that page."""
    for page in tracked():
        folder = page.removesuffix(".md")
        if re.fullmatch(r"docs/\w+\.md", page) and (ROOT / folder).is_dir():
            tested = "\n".join(read(name) for name in sources(folder + "/"))
            for code in re.findall(r"^```cpp\n(.*?)^```$", read(page), re.MULTILINE | re.DOTALL):
                if re.match(r"struct |class ", code) or "int main(" in code:
                    if code not in tested:
                        yield f"{page}: not in {folder}: {code.splitlines()[0]} ..."


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
    packages_stand_where_their_kind_is, includes_run_one_way, dependencies_run_one_way,
    fast_dds_in_one_place, files_stay_small, randomness_is_seeded,
    tests_do_not_sleep, libraries_do_not_ask_the_locale, nothing_is_left_open, sources_carry_the_licence,
    packages_declare_what_they_use, packages_are_described, pages_show_tested_code, formatting,
    no_private_places,
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
