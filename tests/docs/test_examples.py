#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Code in the documents that is marked `<!-- example: FILE -->` stands, line by line, in a file that is compiled."""

import os
import re
import unittest

from test_links import ROOT, documents

EXAMPLE = re.compile(r"<!-- example: (\S+) -->\n```\w*\n(.*?)^```", re.MULTILINE | re.DOTALL)


class Examples(unittest.TestCase):
    def test_they_are_what_is_compiled(self):
        found = 0
        for document in documents():
            with open(document, encoding="utf-8") as file:
                for path, code in EXAMPLE.findall(file.read()):
                    with self.subTest(document=document, path=path), open(os.path.join(ROOT, path), encoding="utf-8") as source:
                        self.assertIn(code, source.read())
                    found += 1
        self.assertGreater(found, 0)


if __name__ == "__main__":
    unittest.main()
