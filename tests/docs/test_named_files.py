#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that comments of C++ sources name exist: by their path, or the end of it."""

import os
import re
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOLDERS = ("client", "protocol", "server", "tests")
COMMENT = re.compile(r"(?<!:)//(.*)")
FILE = re.compile(r"(?<![\w./*-])((?:[\w-]+/)*\w[\w-]*\.(?:h|cpp|py|md))\b")
OF_OTHERS = {"vtkCellType.h"}


def files():
    for top in FOLDERS:
        for folder, folders, names in os.walk(os.path.join(ROOT, top)):
            folders[:] = [name for name in folders if name != "node_modules"]
            yield from (os.path.relpath(os.path.join(folder, name), ROOT) for name in names)
    yield from (os.path.join("docs", name) for name in os.listdir(os.path.join(ROOT, "docs")))
    yield from (os.path.join("scenes", name) for name in os.listdir(os.path.join(ROOT, "scenes")))
    yield from (name for name in os.listdir(ROOT) if name.endswith(".md"))


def ends(path):
    parts = path.split("/")
    return {"/".join(parts[first:]) for first in range(len(parts))}


class NamedFiles(unittest.TestCase):
    def test_they_exist(self):
        paths = sorted(files())
        known = set().union(OF_OTHERS, *(ends(path) for path in paths))
        broken, found = [], 0
        for path in paths:
            if not path.endswith((".h", ".cpp")):
                continue
            with open(os.path.join(ROOT, path), encoding="utf-8") as file:
                for number, line in enumerate(file, 1):
                    comment = COMMENT.search(line)
                    for name in FILE.findall(comment[1]) if comment else ():
                        found += 1
                        if name not in known:
                            broken.append(f"{path}:{number}: {name}")
        self.assertGreater(found, 100)
        self.assertEqual(broken, [], "name no file")


if __name__ == "__main__":
    unittest.main()
