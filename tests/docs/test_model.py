#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What server/MODEL.md names is in the file that it names beside it, and nothing that it names has gone."""

import glob
import os
import re
import subprocess
import sys
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SERVER = os.path.join(ROOT, "server")
NAMES = r"((?:`[\w:()]+`(?:, )?)+)"
FILE = r"`([\w./]+\.(?:h|cpp))`"
PAIRS = (re.compile(NAMES + r"(?:;| in|:)? \(?" + FILE), re.compile(FILE + r" \(" + NAMES))


def contents(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def words_of(names):
    return re.findall(r"\w+", names)


class Model(unittest.TestCase):
    def setUp(self):
        self.page = re.sub(r"\s+", " ", contents(os.path.join(SERVER, "MODEL.md")))

    def pairs(self):
        """(names, file)"""
        for name_first, pattern in zip((True, False), PAIRS):
            for match in pattern.finditer(self.page):
                yield match.groups() if name_first else match.groups()[::-1]

    def test_names_are_in_the_files_beside_them(self):
        found = list(self.pairs())
        self.assertGreater(len(found), 20)
        for names, file in found:
            stem = os.path.splitext(os.path.join(SERVER, file) if not os.path.exists(os.path.join(ROOT, file)) else
                                    os.path.join(ROOT, file))[0]
            text = "".join(contents(stem + ending) for ending in (".h", ".cpp") if os.path.exists(stem + ending))
            for word in words_of(names):
                with self.subTest(file=file):
                    self.assertRegex(text, rf"\b{word}\b")

    def test_its_drawing_is_what_the_script_draws(self):
        script = os.path.join(ROOT, "docs", "draw-model")
        drawn = subprocess.run([sys.executable, script, "--print"], capture_output=True, text=True, timeout=60, check=True).stdout
        self.assertEqual(contents(os.path.join(SERVER, "model_path.svg")), drawn)

    def test_members_exist(self):
        sources = " ".join(contents(path) for ending in ("h", "cpp")
                           for path in glob.glob(os.path.join(SERVER, "**", "*." + ending), recursive=True))
        members = set(re.findall(r"`(\w+(?:::\w+)+)(?:\(\))?`", self.page))
        self.assertGreater(len(members), 20)
        for member in members:
            for word in words_of(member):
                with self.subTest(member=member):
                    self.assertRegex(sources, rf"\b{word}\b")


if __name__ == "__main__":
    unittest.main()
