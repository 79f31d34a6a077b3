#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the pictures of README and docs anew: runs three missions as inspect.sh does and takes their plots.
#
#   make.sh [FOLDER]       FOLDER keeps the missions; those that it has are not run again. Default: a temporary one
#
# Needs a built workspace whose install/local_setup.bash is sourced. Nothing is chosen by hand: of an animation
# the middle frame, of a report the first leak, which is the most severe one.
set -euo pipefail
images=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
compositions=$images/../../launch_scripts
if [ $# -gt 0 ]; then
  missions=$1
else
  missions=$(mktemp -d)
  trap 'rm -rf "$missions"' EXIT
fi
export ROS_LOCALHOST_ONLY=${ROS_LOCALHOST_ONLY-1}

for mission in crawler rack patrol; do
  [ -d "$missions/$mission" ] || pipescout run "$compositions/$mission.yaml" --out "$missions/$mission"
done
pipescout plot odometry "$missions/crawler"
pipescout plot rack "$missions/rack"
pipescout plot tracking "$missions/patrol"

cp "$missions/crawler/pictures/support_graph.svg" "$missions/crawler/pictures/position_error.svg" "$images"
"${PIPESCOUT_PYTHON:-/usr/bin/python3}" - "$missions" "$images" <<'PYTHON'
import re
import sys
from pathlib import Path

from PIL import Image

missions, images = map(Path, sys.argv[1:])


def middle_frame(animation, picture, name):
    """Of an animation its middle frame, without what is drawn below the picture of the camera."""
    with Image.open(picture) as seen:
        aspect = seen.height / seen.width
    with Image.open(animation) as frames:
        frames.seek(frames.n_frames // 2)
        frame = frames.convert("RGB")
        frame.crop((0, 0, frame.width, round(frame.width * aspect))).save(images / name, optimize=True)


def first(folder, pattern):
    return sorted(folder.glob(pattern))[0]


rack, patrol = missions / "rack", missions / "patrol"
middle_frame(rack / "pictures/animation.gif", first(rack, "rack/images/*"), "rack_overlay.png")
middle_frame(patrol / "pictures/tracking.gif", first(patrol, "tracking/pictures/*"), "tracked_pipe.png")

# The plots of a leak, one below the other, with the part of the page's style that they use.
page = (patrol / "report/report.html").read_text(encoding="utf-8")
plots = re.findall(r'<svg class="plot" viewBox="0 0 (\d+) (\d+)"[^>]*>(.*?)</svg>', page, re.DOTALL)[:3]
width, height = max(int(plot[0]) for plot in plots), sum(int(plot[1]) for plot in plots)
lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
         "<style>text{font:11px sans-serif;fill:#3c444c}.title{font-weight:bold}.grid line{stroke:#e3e7ea}</style>"
         f'<rect width="{width}" height="{height}" fill="white"/>']
top = 0
for _, part, content in plots:
    lines.append(f'<g transform="translate(0,{top})">{content}</g>')
    top += int(part)
(images / "leak_profile.svg").write_text("\n".join([*lines, "</svg>"]) + "\n", encoding="utf-8")
PYTHON
ls -l "$images"
