#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Looks at object files of kernels (server/engine/math/kernel_set.h): what such a file defines for the whole program must be
in the namespace of its instruction set, so that the linker never takes it for code of another one.
Usage: kernel_symbols.py NAMESPACE OBJECT..."""

import re
import subprocess
import sys


def misplaced(namespace, symbols):
    """The lines of `nm -C` that define something of another namespace."""
    own = re.compile(rf"\bacus::{namespace}::")
    # Not inline constants (u): they are no code, and the same for all sets.
    lines = [line for line in symbols.splitlines() if re.match(r"[0-9a-f]+ [A-Zvw] ", line)]
    return [line for line in lines if not own.search(line)]


def main(namespace, objects):
    if not objects:
        sys.exit("no object files")
    assert misplaced("v4", "0000 W int std::max<int>(int)\n0000 t acus::f()\n         U memset\n0000 D acus::v4::table")
    assert not misplaced("v4", "0000 u acus::kTable")
    failed = 0
    for file in objects:
        symbols = subprocess.run(["nm", "-C", file], capture_output=True, text=True, check=True).stdout
        assert f"acus::{namespace}::" in symbols, f"{file} defines nothing in acus::{namespace}"
        for line in misplaced(namespace, symbols):
            failed += 1
            print(f"{file}: {line.split(' ', 2)[2]} is not in acus::{namespace}")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
