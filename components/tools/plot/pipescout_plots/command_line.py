# SPDX-License-Identifier: Apache-2.0
"""The command line. Loads what draws only when it is to draw, so that
a wrong command line is told, and help given, without it."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path

from .completion import COMPLETE, completions

SUBJECTS = {
    "odometry": "odometers, welds and positions in the pipe, lists of welds and ledgers",
    "navigation": "a robot that is navigated through a plant",
    "rack": "flights over a pipe rack, and camera poses over one",
    "leaks": "leaks that were found",
    "tracking": "the track of a pipe, and the arm",
    "estimator": "a state estimator and its sources, and trajectories of recordings",
}
DEBIAN_PACKAGES = {"matplotlib": "python3-matplotlib", "numpy": "python3-numpy", "PIL": "python3-pil",
                   "yaml": "python3-yaml"}
"""By what is imported of them."""
OPTIONS_WITH_A_VALUE = ("--out", "--format")


def main(arguments: Sequence[str]) -> int:
    if arguments[:1] == [COMPLETE]:
        for word in completions(_parser(), SUBJECTS, arguments[2:]):
            print(word)
        return 0
    options = _parse(arguments)
    try:
        result = importlib.import_module(".result", __package__)
    except ModuleNotFoundError as problem:
        _explain_missing(problem)
    return result.draw(options)


def _parser() -> argparse.ArgumentParser:
    subjects = "\n".join(f"  {name:11} {what}" for name, what in SUBJECTS.items())
    parser = argparse.ArgumentParser(
        prog="pipescout plot", allow_abbrev=False, usage="%(prog)s [-h] [SUBJECT] RESULT [--out DIR] [--format svg|png]",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Plot what RESULT holds; prints path of each plot and what it shows, the one to open first first.",
        epilog=f"SUBJECT draws no other than:\n{subjects}")
    parser.add_argument("words", nargs="*", metavar="[SUBJECT] RESULT",
                        help="a mission folder; what estimate, rack track, track, inspect, ledger and summary wrote, folder or "
                        "list; or the JSON file of `pipescout reproduce`")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the plots; default: RESULT/pictures")
    parser.add_argument("--format", choices=("svg", "png"), default="svg",
                        help="format of the plots except animations, which are GIF; default: %(default)s")
    return parser


def _parse(arguments: Sequence[str]) -> argparse.Namespace:
    parser = _parser()
    options = parser.parse_intermixed_args(_with_values_joined(arguments))
    words = options.words
    if not words or (len(words) == 1 and words[0] in SUBJECTS and not Path(words[0]).exists()):
        parser.error("RESULT is missing")
    if len(words) > 2:
        parser.error(f"one RESULT at a time, not also '{words[2]}'")
    if len(words) == 2 and words[0] not in SUBJECTS:
        parser.error(f"unknown SUBJECT '{words[0]}'; there are {', '.join(SUBJECTS)}")
    options.subject = words[0] if len(words) == 2 else None
    options.result = Path(words[-1])
    return options


def _with_values_joined(arguments: Sequence[str]) -> list[str]:
    """"--out", "-p" as "--out=-p": argparse would take a path that begins with '-' for an option."""
    joined: list[str] = []
    words = iter(arguments)
    for word in words:
        if word == "--":
            return [*joined, word, *words]
        value = next(words, None) if word in OPTIONS_WITH_A_VALUE else None
        joined.append(word if value is None else f"{word}={value}")
    return joined


def _explain_missing(problem: ModuleNotFoundError) -> None:
    missing = [package for module, package in DEBIAN_PACKAGES.items()
               if importlib.util.find_spec(module) is None]
    if not missing:
        raise problem
    sys.exit(f"pipescout plot: {sys.executable} cannot load the plotting library ({problem}); install "
             f"the Debian package{'s' if len(missing) > 1 else ''} {', '.join(missing)}, or name another "
             "Python in PIPESCOUT_PYTHON")
