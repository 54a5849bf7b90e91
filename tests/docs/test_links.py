#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Links and paths in the Markdown documents lead to files that exist, and links to sections to headings."""

import glob
import os
import re
import unittest

SOURCES = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
ROOT = os.environ.get("ACUS_DOCUMENTS", SOURCES)  # the documents as they are installed, for instance
LEFT_OUT = ("build", "out", ".git", "node_modules")
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
# A file's path in backquotes, as seen from the project's folder, from that of the document or from server/.
PATH = re.compile(r"`((?:[\w.-]+/)+[\w*-]+\.(?:h|cpp|py|md|yaml|csv|json|txt|cmake))`")
MADE = ("out/", "run/")  # what programs write
CODE = re.compile(r"^```.*?^```|^ {4}.*?$", re.MULTILINE | re.DOTALL)
HEADING = re.compile(r"^#+ +(.*?)\s*$", re.MULTILINE)


def documents():
    for folder, folders, files in os.walk(ROOT):
        folders[:] = [name for name in folders if name != "node_modules" and os.path.join(folder, name) not in
                      [os.path.join(ROOT, left_out) for left_out in LEFT_OUT]]
        yield from (os.path.join(folder, name) for name in files if name.endswith(".md"))


def text_of(document):
    """Without examples of code, whose lines stay empty."""
    with open(document, encoding="utf-8") as file:
        return CODE.sub(lambda match: "\n" * match[0].count("\n"), file.read())


def anchors(document):
    """As GitHub makes them: lower case, words joined by '-', no other signs."""
    headings = HEADING.findall(text_of(document))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


class Documents(unittest.TestCase):
    def setUp(self):
        self.documents = sorted(documents())
        self.assertIn(os.path.join(ROOT, "README.md"), self.documents)

    def check(self, pattern, found):
        broken = []
        for document in self.documents:
            text = text_of(document)
            for match in pattern.finditer(text):
                if not found(document, match[1]):
                    line = text.count("\n", 0, match.start()) + 1
                    broken.append(f"{os.path.relpath(document, ROOT)}:{line}: {match[1]}")
        self.assertEqual(broken, [], "lead nowhere")

    def test_links(self):
        def found(document, link):
            if re.match(r"[a-z]+:", link):
                return True
            path, _, section = link.partition("#")
            target = os.path.normpath(os.path.join(os.path.dirname(document), path)) if path else document
            return os.path.exists(target) and (not section or section in anchors(target))

        self.check(LINK, found)

    def test_paths(self):
        def found(document, path):
            folders = (ROOT, os.path.dirname(document), os.path.join(ROOT, "server"))
            return path.startswith(MADE) or any(glob.glob(os.path.join(folder, path)) for folder in folders)

        self.check(PATH, found)

    def test_headings_become_anchors(self):
        self.assertIn("the-tick", anchors(os.path.join(ROOT, "server", "MODEL.md")))


if __name__ == "__main__":
    unittest.main()
