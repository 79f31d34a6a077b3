#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the pictures of a subject; `pipescout plot` runs this. --help tells the options."""

import sys

from pipescout_plots.command_line import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
