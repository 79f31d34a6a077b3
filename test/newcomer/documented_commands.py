# SPDX-License-Identifier: Apache-2.0
"""The command lines that pages show: in fenced and in indented blocks, a line each.

A line may be a synopsis: "pipescout map check|show GRID.yaml [--out PICTURE]". What is optional is left out, each
alternative becomes a command, and words in capitals are placeholders.
"""

import pathlib
import re
from dataclasses import dataclass

PROGRAMS = {"pipescout", "colcon", "cmake", "ctest", "cp", "export", "source", "sudo", "apt", "systemctl", "scp", "tar",
            "sqlite3", "slip_alarm", "launch_scripts/fleet.sh", "launch_scripts/package.sh", "./launch_scripts/inspect.sh",
            "./test/run.sh"}
# "[--out DIR]", "[TOPIC ...]", innermost first.
OPTIONAL = re.compile(r"\s*\[[^\[\]]*\]")
PLACEHOLDER = re.compile(r"(?<![\w$/.-])[A-Z][A-Z_]*[A-Z](?:\.\w+)?(?![\w=])|(?<![\w$/.-])N(?![\w=])")


@dataclass(frozen=True)
class Line:
    page: str
    number: int
    text: str
    """As the page has it, without its comment."""

    @property
    def place(self):
        return f"{self.page}:{self.number}"


def lines_of(root, page):
    """The command lines of a page, in its order."""
    found = []
    for number, block in _blocks((pathlib.Path(root) / page).read_text(encoding="utf-8").splitlines()):
        first = block[0].split()[0] if block[0].split() else ""
        if first not in PROGRAMS and "=" not in first:
            continue
        text, at = "", number
        for offset, line in enumerate(block):
            continued = text.endswith("\\") or (text and re.match(r"\s{4,}\S", line))
            if continued:
                text = text.rstrip("\\").rstrip() + " " + line.strip()
                continue
            if text:
                found.append(Line(page, at, _without_comment(text)))
            text, at = line.rstrip(), number + offset
        if text:
            found.append(Line(page, at, _without_comment(text)))
    return [line for line in found if line.text and not line.text.startswith("#")]


def _blocks(lines):
    """(number of its first line, its lines without the indentation) of each fenced block without a language, and of
    each indented block."""
    block, start, fence = [], 0, None
    for number, line in enumerate([*lines, ""], 1):
        if line.startswith("```"):
            if fence is None:
                fence, block, start = line[3:].strip(), [], number + 1
            else:
                if fence in ("", "sh", "bash") and block:
                    yield start, block
                fence, block = None, []
        elif fence is not None:
            block.append(line)
        elif line.startswith("    ") and (block or not lines[number - 2].strip()):
            if not block:
                start = number
            block.append(line[4:])
        elif block:
            yield start, block
            block = []


def _without_comment(text):
    """"COMMAND   # why" and "COMMAND   what it does", as tables of commands have it."""
    quoted = [match.span() for match in re.finditer(r'"[^"]*"', text)]
    for match in re.finditer(r"\s+#\s|\s{3,}", text):
        if not any(begin < match.start() < end for begin, end in quoted):
            return text[:match.start()].strip()
    return text.strip()


def commands_of(text, values):
    """The commands that a line stands for, with `values` in the place of placeholders; a placeholder without a value
    stays."""
    text = re.sub(r"\s*\.\.\.", " ", _without_options(text))
    words = [word.split("|") if re.fullmatch(r"[\w./-]+(\|[\w./-]+)+", word) else [word] for word in text.split(" ")]
    commands = [""]
    for choice in words:
        commands = [f"{command} {word}".strip() for command in commands for word in choice]
    return [PLACEHOLDER.sub(lambda found: values.get(found.group(), found.group()), command) for command in commands]


def _without_options(text):
    quoted = re.findall(r'"[^"]*"', text)
    for index, each in enumerate(quoted):
        text = text.replace(each, f"\0{index}\0")
    shorter = None
    while shorter != text:
        text, shorter = OPTIONAL.sub("", text), text
    for index, each in enumerate(quoted):
        text = text.replace(f"\0{index}\0", each)
    return text


def placeholders(command):
    return PLACEHOLDER.findall(re.sub(r'"[^"]*"', "", command))
