# SPDX-License-Identifier: Apache-2.0
"""What a shell offers when the user presses the tab key, from the command line as it is declared. The questions and
the form of the answers are those of pipescout/command_line/completion.hpp."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence

COMPLETE = "__complete"
"""The hidden first word: "__complete -- odometry --f"."""


def completions(parser: argparse.ArgumentParser, subjects: Iterable[str], words: Sequence[str]) -> list[str]:
    """What can stand in the place of the last of `words`: a subject as the first argument, else a file, which the shell
    offers by itself."""
    *given, begun = words or [""]
    options = {name: action for action in parser._actions for name in action.option_strings}
    awaiting: argparse.Action | None = None
    arguments = 0
    for word in given:
        name, sign, _ = word.partition("=")
        if awaiting is not None:
            awaiting = None
        elif name in options:
            awaiting = options[name] if options[name].nargs != 0 and not sign else None
        else:
            arguments += 1
    name, sign, _ = begun.partition("=")
    offered: Iterable[str] = ()
    if awaiting is not None:
        offered = awaiting.choices or ()
    elif sign and name in options:
        offered = [f"{name}={value}" for value in options[name].choices or ()]
    elif begun.startswith("-"):
        offered = options
    elif arguments == 0:
        offered = subjects
    return sorted(each for each in offered if each.startswith(begun))
