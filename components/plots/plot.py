#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the pictures of a subject; `pipescout plot` runs this. --help tells the options."""

import sys

try:
    import matplotlib  # noqa: F401
    import yaml  # noqa: F401
except ImportError as problem:
    package = "python3-yaml" if problem.name == "yaml" else "python3-matplotlib"
    sys.exit(f"pipescout plot: {sys.executable} cannot load what draws the pictures ({problem}); "
             f"install the Debian package {package}, or name another Python in PIPESCOUT_PYTHON")

from pipescout_plots.command_line import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
