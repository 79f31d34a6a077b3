#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""No symbol is defined by two of our libraries: components of one process share one table of
symbols, so the library that is loaded first would lend its definition to the other.

    exported_symbols_test.py
"""

import collections
import os
import pathlib
import subprocess

LEAST_LIBRARIES = 20  # fewer found: the search is broken
STRONG = "TDBRGS"  # kinds that nm gives to definitions which are not weak
OF_THE_LINKER = {"_init", "_fini", "__bss_start", "_edata", "_end"}


def libraries():
    prefixes = os.environ["CMAKE_PREFIX_PATH"].split(os.pathsep)
    found = {library.resolve() for prefix in prefixes
             for library in pathlib.Path(prefix, "lib").glob("libpipescout_*.so")}
    assert len(found) >= LEAST_LIBRARIES, f"only {len(found)} libraries in {prefixes}"
    return sorted(found)


def strong_symbols(library):
    listing = subprocess.run(["nm", "--dynamic", "--defined-only", "--demangle", library],
                             check=True, capture_output=True, text=True).stdout
    for line in listing.splitlines():
        _, kind, name = line.split(maxsplit=2)
        if kind in STRONG and name not in OF_THE_LINKER:
            yield name


def main():
    owners = collections.defaultdict(set)
    for library in libraries():
        for name in strong_symbols(library):
            owners[name].add(library.name)
    clashes = [f"{name}: {', '.join(sorted(where))}"
               for name, where in sorted(owners.items()) if len(where) > 1]
    assert not clashes, "\n".join(clashes)
    print(f"{len(owners)} symbols, each defined once")


if __name__ == "__main__":
    main()
