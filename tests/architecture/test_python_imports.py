#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The package acus does not import its programs: acus.apps, whose modules choose a backend and read command lines."""

import ast
import os
import unittest

PACKAGE = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "client", "python", "acus")


def imported(tree):
    """Names of modules, without the dots in front."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module or ''}.{each.name}" for each in node.names)


class Library(unittest.TestCase):
    def test_it_does_not_import_programs(self):
        read = 0
        for folder, _, names in os.walk(PACKAGE):
            if os.path.relpath(folder, PACKAGE).split(os.sep)[0] == "apps":
                continue
            for name in sorted(names):
                if not name.endswith(".py"):
                    continue
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    tree = ast.parse(file.read())
                read += 1
                programs = [each for each in imported(tree) if "apps" in each.split(".")]
                self.assertEqual(programs, [], os.path.join(folder, name))
        self.assertGreater(read, 50)


if __name__ == "__main__":
    unittest.main()
