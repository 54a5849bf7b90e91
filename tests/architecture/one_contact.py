#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that one place makes rows and reads their forces: tick/contact/contact.h.

Prints each line of another file of server/engine/tick that builds a Row, or adds one of its own, and ends with 1 if there
is one. What finds a contact fills in a Contact; so a new kind needs no row, no state and no reader of its own."""

import argparse
import os
import re
import sys

MAKER = "server/engine/tick/contact/contact"
OF_ROWS = re.compile(r"\bRow\b|\brows\.add\b|\badd_(?:cone|disk)\b")


def found_in(root):
    for folder, folders, files in os.walk(os.path.join(root, "server/engine/tick")):
        folders.sort()
        for name in sorted(files):
            path = os.path.relpath(os.path.join(folder, name), root)
            if not name.endswith((".h", ".cpp")) or os.path.splitext(path)[0] == MAKER:
                continue
            with open(os.path.join(root, path), encoding="utf-8") as file:
                for number, line in enumerate(file, 1):
                    if OF_ROWS.search(line.split("//")[0]):
                        yield f"{path}:{number}: {line.strip()}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", metavar="ROOT", help="of the sources")
    root = parser.parse_args().root
    if not os.path.exists(os.path.join(root, MAKER + ".cpp")):
        sys.exit(f"no {MAKER}.cpp there")
    found = list(found_in(root))
    print("\n".join([*found, "fill in a Contact instead"]) if found else "rows are made in one place")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
