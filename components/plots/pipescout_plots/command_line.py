# SPDX-License-Identifier: Apache-2.0
"""The command line: a subject, then its own arguments."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from . import odometry
from .estimator import subject as estimator
from .rack import subject as rack
from .tracking import subject as tracking

# Each subject is a module with add_arguments(parser) and run(options), which gives the exit code.
SUBJECTS = {
    "estimator": estimator,
    "odometry": odometry,
    "rack": rack,
    "tracking": tracking,
}


def main(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(prog="pipescout plot", allow_abbrev=False)
    subjects = parser.add_subparsers(dest="subject", required=True, metavar="SUBJECT")
    for name, module in SUBJECTS.items():
        module.add_arguments(subjects.add_parser(name, allow_abbrev=False,
                                                 help=module.__doc__.splitlines()[0]))
    options = parser.parse_args(arguments)
    return SUBJECTS[options.subject].run(options)
