#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the text of a terminal as an SVG: terminal_svg.py TITLE < text > picture.svg

Files below the current folder are shown relative to it: where that is differs between machines.

The README's picture:
    pipescout run launch_scripts/odometry.yaml --out mission 2>&1 |
      docs/images/terminal_svg.py "pipescout run launch_scripts/odometry.yaml --out mission" \\
        > docs/images/inspect.svg
"""

import html
import os
import re
import sys

CHARACTER, LINE, MARGIN = 7.2, 17, 16


def main():
    title = sys.argv[1]
    text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", sys.stdin.read())
    text = text.replace(os.getcwd() + "/", "")
    # What a carriage return overwrites is not seen.
    lines = [line.rsplit("\r", 1)[-1].rstrip() for line in text.rstrip().split("\n")]
    lines = [re.sub(r"\[(\w+)\] \[\d+\.\d+\] ", r"[\1] ", line) for line in lines]
    width = max(len(line) for line in [*lines, "$ " + title]) * CHARACTER + 2 * MARGIN
    height = (len(lines) + 1) * LINE + 2 * MARGIN
    print(f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height}" '
          f'viewBox="0 0 {width:.0f} {height}" role="img" aria-label="{html.escape(title)}">')
    print(f'<rect width="100%" height="100%" rx="8" fill="#14202b"/>')
    print('<g font-family="DejaVu Sans Mono, Menlo, Consolas, monospace" font-size="12" '
          'fill="#d7e0e8" xml:space="preserve">')
    rows = [("$ " + title, "#7fd1b9")] + [(line, colour(line)) for line in lines]
    for index, (line, fill) in enumerate(rows):
        y = MARGIN + LINE * (index + 0.75)
        print(f'<text x="{MARGIN}" y="{y:.0f}" fill="{fill}">{html.escape(line)}</text>')
    print("</g>\n</svg>")


def colour(line):
    if line.startswith("[INFO]"):
        return "#8aa0b2"
    if line.startswith("[WARN]"):
        return "#e8c268"
    return "#d7e0e8"


if __name__ == "__main__":
    main()
