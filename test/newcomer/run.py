#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs every command line of README.md and of the pages in docs/ as a newcomer does, after launch_scripts/inspect.sh.

    test/newcomer/run.py [--json FILE] [--only PAGE] [--list]

What stands for the reader's own data, what runs beside a page, and what is not run and why: substitutions.yaml. Ends
with "newcomer_commands_failing N" and names them; exits with 0 when N is 0. Commands run in the root of the project,
with a home folder of their own; what they leave in the root is removed. Takes some ten minutes, and no network.
"""

import argparse
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

import yaml

from documented_commands import Line, commands_of, lines_of, placeholders

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PATIENCE = 300  # s for a command, unless substitutions.yaml gives it more; none should come near
STOPPED = {0, 128 + signal.SIGINT, -signal.SIGINT}


class Command:
    """A command line in bash, with the environment of the workspace, as the leader of a group of processes."""

    def __init__(self, text, before, scratch, environment):
        script = "\n".join(["source install/setup.bash", *before, text])
        self.text = text
        self.out, self.changed = "", threading.Condition()
        self.process = subprocess.Popen(
            ["bash", "-c", script], cwd=ROOT, start_new_session=True, stdin=subprocess.DEVNULL, text=True,
            errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            env={**environment, "HOME": str(scratch / "home"), "S": str(scratch)})
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            with self.changed:
                self.out += line
                self.changed.notify_all()
        with self.changed:
            self.changed.notify_all()

    def wait_for(self, pattern, seconds):
        """Until its output has the pattern; whether it came."""
        with self.changed:
            self.changed.wait_for(lambda: re.search(pattern, self.out) or not self.reader.is_alive() or
                                  self.process.poll() is not None, seconds)
            return re.search(pattern, self.out) is not None

    def stop(self):
        """As Ctrl-C does; the exit code."""
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGINT)
        return self.wait(60)

    def wait(self, seconds):
        """The exit code; None when it does not end."""
        try:
            code = self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
            return None
        self.reader.join(10)
        return code


class Table:
    def __init__(self, file):
        table = yaml.safe_load(file.read_text(encoding="utf-8"))
        self.samples = table["samples"]
        self.not_run = table["not_run"]
        self.instead = table["instead"]
        self.values = table["values"]
        self.endless = table["endless"]
        self.beside = table["beside"]
        self.background = table["background"]

    @staticmethod
    def _first(entries, text):
        return next((entry for entry in entries if re.match(entry["line"], text)), None)

    def reason_not_to_run(self, text):
        entry = self._first(self.not_run, text)
        return entry["reason"] if entry else None

    def commands(self, line):
        entry = next((entry for entry in self.instead
                      if re.match(entry["line"], line.text) and entry.get("page", line.page) == line.page), None)
        if entry:
            return entry["run"]
        values = {**self.values["all"], **self.values.get(line.page, {})}
        commands = commands_of(line.text, values)
        return [command for command in commands if not self._left_open(command)] or commands

    @staticmethod
    def _left_open(command):
        return [each for each in placeholders(command) if not each.startswith("$")]

    def ends_by_ctrl_c(self, command):
        """What its output has when it works; nothing when it ends by itself."""
        entry = self._first(self.endless, command)
        return entry.get("until", r"\S") if entry else None

    def stays(self, command):
        """Of a command that runs until the page ends: what its output has when the next commands may come."""
        entry = self._first(self.background, command)
        return entry["until"] if entry else None


class Newcomer:
    def __init__(self, table, scratch):
        self.table, self.scratch = table, scratch
        self.environment = {**os.environ, "ROS_LOCALHOST_ONLY": "1"}
        self.rows = []
        (scratch / "home").mkdir()

    def make_samples(self):
        for mission in ("odometry", "crawler", "rack", "patrol"):
            found = sorted((ROOT / "missions").glob(f"{mission}_20*"))
            if not found:
                print(f"run.py: missions/{mission}_* is not there; run launch_scripts/inspect.sh first", file=sys.stderr)
            self.environment[mission.upper()] = str(found[-1] if found else ROOT / "missions" / mission)
        for text in self.table.samples:
            command = Command(text, [], self.scratch, self.environment)
            if command.wait(PATIENCE) != 0:
                print(f"run.py: a sample could not be made: {text}\n{_tail(command.out)}", file=sys.stderr)

    def run_page(self, page):
        before, running = [], []
        for text in self.table.beside.get(page, []):
            command = Command(text["run"], [], self.scratch, self.environment)
            running.append((Line(page, 0, text["run"]), command))
            if not command.wait_for(text["until"], PATIENCE):
                sys.exit(f"run.py: {text['run']} does not start:\n{command.out}")
        for line in lines_of(ROOT, page):
            reason = self.table.reason_not_to_run(line.text)
            if reason:
                self._note(line, line.text, "not run", reason)
                continue
            for command in self.table.commands(line):
                self._run(line, command, before, running)
        for line, command in reversed(running):
            code = command.stop()
            if code not in STOPPED:
                self._note(line, command.text, "failed", f"exit code {code} after Ctrl-C", out=command.out)

    def _run(self, line, text, before, running):
        if re.match(r"(export|source) ", text):
            before.append(text)
            text = "true"
        start = time.monotonic()
        command = Command(text, before, self.scratch, self.environment)
        stays, endless = self.table.stays(text), self.table.ends_by_ctrl_c(text)
        if stays:
            good = command.wait_for(stays, PATIENCE)
            problem = "" if good else f"no {stays!r}"
            running.append((line, command))
        elif endless:
            good = command.wait_for(endless, PATIENCE)
            code = command.stop()
            problem = f"no {endless!r}" if not good else "" if code in STOPPED else f"exit code {code}"
        else:
            code = command.wait(PATIENCE)
            problem = "" if code == 0 else "does not end" if code is None else f"exit code {code}"
        shown = before[-1] if text == "true" and before else text
        self._note(line, shown, "failed" if problem else "ok", problem, time.monotonic() - start, command.out)

    def _note(self, line, command, result, why, seconds=0.0, out=""):
        self.rows.append({"place": line.place, "line": line.text, "command": command, "result": result, "why": why,
                          "seconds": round(seconds, 1)})
        print(f"{result:8} {line.place}: {command}" + (f"   ({why})" if why else f"   {seconds:.1f} s"), flush=True)
        if result == "failed":
            print(_tail(out), flush=True)


def _tail(text, count=8):
    return "\n".join("     | " + line for line in text.rstrip().splitlines()[-count:])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE")
    parser.add_argument("--only", metavar="PAGE", help="such as docs/actions.md")
    parser.add_argument("--list", action="store_true", help="only name what would run")
    options = parser.parse_args()
    table = Table(HERE / "substitutions.yaml")
    pages = ["README.md", *sorted(str(page.relative_to(ROOT)) for page in (ROOT / "docs").glob("*.md"))]
    pages = [page for page in pages if options.only in (None, page)]
    if options.list:
        for line in (line for page in pages for line in lines_of(ROOT, page)):
            reason = table.reason_not_to_run(line.text)
            for command in [f"not run: {reason}"] if reason else table.commands(line):
                print(f"{line.place}: {line.text}\n    {command}")
        return 0
    present = set(os.listdir(ROOT)) | {f"missions/{name}" for name in os.listdir(ROOT / "missions")}
    with tempfile.TemporaryDirectory(prefix="pipescout_newcomer_") as folder:
        newcomer = Newcomer(table, pathlib.Path(folder))
        try:
            newcomer.make_samples()
            for page in pages:
                newcomer.run_page(page)
        finally:
            for name in [*os.listdir(ROOT), *(f"missions/{name}" for name in os.listdir(ROOT / "missions"))]:
                if name not in present | {"log"}:
                    path = ROOT / name
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
    count = {result: sum(row["result"] == result for row in newcomer.rows) for result in ("ok", "not run", "failed")}
    print(f"\n{len(newcomer.rows)} commands: {count['ok']} work, {count['not run']} are not run:")
    for reason in sorted({row["why"] for row in newcomer.rows if row["result"] == "not run"}):
        print(f"  {sum(row['why'] == reason for row in newcomer.rows):3}  {reason}")
    print(f"\nnewcomer_commands_failing {count['failed']}")
    for row in newcomer.rows:
        if row["result"] == "failed":
            print(f"  {row['place']}: {row['command']}: {row['why']}")
    if options.json:
        options.json.write_text(json.dumps({
            "figures": {"newcomer_commands_failing": count["failed"], "newcomer_commands_not_run": count["not run"],
                        "newcomer_commands": len(newcomer.rows)},
            "rows": newcomer.rows, "seeds": []}, indent=1) + "\n", encoding="utf-8")
    return 1 if count["failed"] else 0


if __name__ == "__main__":
    sys.exit(main())
