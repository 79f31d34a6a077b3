# SPDX-License-Identifier: Apache-2.0
"""The command line: a subject, then its own arguments. Loads what draws only when it is to draw, so that
a wrong command line is told, and help given, without it."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Subject:
    module: str
    """Has run(options), which gives the exit code."""
    help: str
    table: str
    """Whose JSON file it draws too: of `pipescout reproduce TABLE`."""
    aligns: bool = False
    """Draws a ledger's alignment."""


SUBJECTS = {
    "odometry": Subject("odometry", "odometers, welds and positions in the pipe", "in-pipe", aligns=True),
    "rack": Subject("rack.subject", "flights over a pipe rack", "rack"),
    "estimator": Subject("estimator.subject", "a state estimator and its sources", "estimator"),
    "navigation": Subject("navigation.subject", "a robot that is navigated through a plant", "navigation"),
    "tracking": Subject("tracking.subject", "the track of a pipe, and the arm", "tracking"),
}
DEBIAN_PACKAGES = {"matplotlib": "python3-matplotlib", "numpy": "python3-numpy", "PIL": "python3-pil",
                   "yaml": "python3-yaml"}
"""By what is imported of them."""
OPTIONS_WITH_A_VALUE = ("--out", "--format", "--alignment")


def main(arguments: Sequence[str]) -> int:
    options = _parse(arguments)
    try:
        subject = importlib.import_module(f".{SUBJECTS[options.subject].module}", __package__)
    except ModuleNotFoundError as problem:
        _explain_missing(problem)
    return subject.run(options)


def _parse(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipescout plot", allow_abbrev=False,
        description="Plot a recorded mission; prints the path of each plot.")
    subjects = parser.add_subparsers(dest="subject", required=True, metavar="SUBJECT")
    for name, subject in SUBJECTS.items():
        command = subjects.add_parser(name, allow_abbrev=False, help=subject.help,
                                      description=f"Plots of {subject.help}.")
        command.add_argument("result", type=Path, metavar="RESULT",
                             help="a mission folder, or the JSON file of "
                             f"`pipescout reproduce {subject.table}`")
        command.add_argument("--out", type=Path, metavar="DIR",
                             help="folder of the plots; default: RESULT/pictures")
        command.add_argument("--format", choices=("svg", "png"), default="svg",
                             help="format of the plots except animations, which are GIF; default: %(default)s")
        if subject.aligns:
            command.add_argument("--alignment", type=Path, metavar="FILE",
                                 help="output of `pipescout ledger align --report`; default: "
                                 "RESULT/alignment.csv")
    return parser.parse_args(_with_values_joined(arguments))


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
