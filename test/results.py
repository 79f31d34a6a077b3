#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Says what a run of ctest gave, each Google test counted by itself.

    results.py BUILD_BASE

Reads BUILD_BASE/ctest_results.xml, which ctest wrote, and of entries that are executables of Google
tests BUILD_BASE/*/test_results/ENTRY.xml. Names what failed, with the end of its output, and closes
with "N passed, N failed, N skipped". Exits with 1 when something failed or nothing ran.
"""

import pathlib
import sys
import xml.etree.ElementTree as ElementTree

LINES_OF_OUTPUT = 60


def is_chosen_skip(skipped):
    """False where ctest could not start the test, which it calls skipped too."""
    return skipped is not None and skipped.get("message", "").startswith("SKIP_")


class Results:
    def __init__(self):
        self.passed = 0
        self.skipped = 0
        self.failed = []  # name, output

    def add_entry(self, entry, google_tests):
        """`entry`: a test case as ctest wrote it; `google_tests`: the file it left, or None."""
        name = entry.get("name")
        status = entry.get("status")
        skipped = entry.find("skipped")
        failed_before = len(self.failed)
        if google_tests is not None:
            self._add_google_tests(name, google_tests)
        elif status == "run":
            self.passed += 1
        elif status == "disabled" or is_chosen_skip(skipped):
            self.skipped += 1
        if status in ("fail", "notrun") and not is_chosen_skip(skipped) and \
                len(self.failed) == failed_before:
            # It never began, crashed, ran out of time, or a sanitizer found something at its end.
            self.failed.append((name, entry.findtext("system-out") or ""))

    def _add_google_tests(self, entry, file):
        try:
            cases = ElementTree.parse(file).iter("testcase")
        except ElementTree.ParseError as error:
            self.failed.append((entry, f"{file}: {error}"))
            return
        for case in cases:
            if case.get("status") == "notrun":  # DISABLED_
                self.skipped += 1
            elif (failures := case.findall("failure")):
                name = f"{entry} {case.get('classname')}.{case.get('name')}"
                self.failed.append((name, "\n".join(failure.text or "" for failure in failures)))
            elif case.find("skipped") is not None:
                self.skipped += 1
            else:
                self.passed += 1


def main(base):
    results = Results()
    written = base / "ctest_results.xml"
    if written.is_file():
        for entry in ElementTree.parse(written).iter("testcase"):
            files = sorted(base.glob(f"*/test_results/{entry.get('name')}.xml"))
            results.add_entry(entry, files[0] if files else None)
    for name, output in results.failed:
        print(f"--- {name}")
        print("\n".join(output.splitlines()[-LINES_OF_OUTPUT:]))
    if results.failed:
        print("failed, by name:")
        for name, _ in results.failed:
            print(f"- {name}")
    count = results.passed + len(results.failed) + results.skipped
    if count == 0:
        print("no test ran")
    print(f"{results.passed} passed, {len(results.failed)} failed, {results.skipped} skipped")
    return 1 if results.failed or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
