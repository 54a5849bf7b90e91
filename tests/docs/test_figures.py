#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of the documents are those of docs/figures.json, and docs/update-figures keeps them so."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FIGURE = {"name": "force", "value": "1.4 N", "command": "scripts/report", "commit": "0123abc", "date": "2020-01-02"}


def update(*arguments):
    return subprocess.run([sys.executable, os.path.join(ROOT, "docs", "update-figures"), *arguments],
                          capture_output=True, text=True, timeout=60, check=False)


class Project(unittest.TestCase):
    """The documents of this project."""

    def test_documents_hold_the_figures(self):
        run = update("--check")
        self.assertEqual(run.returncode, 0, run.stderr)


class Script(unittest.TestCase):
    """The script, on a project of two documents."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = folder.name
        os.mkdir(os.path.join(self.root, "docs"))
        self.put_figures([FIGURE])
        self.put("README.md", "It takes <!-- figure: force -->1.3 N<!-- /figure --> to go in.\n")
        self.put("docs/results.md", "Nothing.\n")

    def put(self, name, text):
        with open(os.path.join(self.root, name), "w", encoding="utf-8") as file:
            file.write(text)

    def put_figures(self, figures):
        self.put("docs/figures.json", json.dumps(figures))

    def get(self, name):
        with open(os.path.join(self.root, name), encoding="utf-8") as file:
            return file.read()

    def run_script(self, *arguments):
        return update("--root", self.root, *arguments)

    def test_check_finds_a_document_that_differs_and_changes_nothing(self):
        before = self.get("README.md")
        run = self.run_script("--check")
        self.assertEqual(run.returncode, 1)
        self.assertIn("README.md differs", run.stderr)
        self.assertEqual(self.get("README.md"), before)

    def test_values_are_written(self):
        self.assertEqual(self.run_script().returncode, 0)
        self.assertEqual(self.get("README.md"), "It takes <!-- figure: force -->1.4 N<!-- /figure --> to go in.\n")
        self.assertEqual(self.run_script("--check").returncode, 0)

    def test_a_figure_that_the_file_lacks_is_named_with_its_line(self):
        self.put("docs/results.md", "one\n<!-- figure: depth -->1<!-- /figure -->\n")
        run = self.run_script()
        self.assertEqual(run.returncode, 1)
        self.assertIn("docs/results.md:2: docs/figures.json has no figure 'depth'", run.stderr)
        self.assertIn("1.3 N", self.get("README.md"))

    def test_a_figure_that_no_document_has_is_named(self):
        self.put("README.md", "")
        self.assertIn("no document has the figure 'force'", self.run_script("--check").stderr)

    def test_comments_without_partner_are_refused(self):
        for text in ("<!-- figure: force -->1", "<!-- figure: Force -->1<!-- /figure -->", "1<!-- /figure -->",
                     "<!-- figures -->\n1\n<!-- /figures -->\n"):
            self.put("docs/results.md", text)
            run = self.run_script("--check")
            self.assertEqual(run.returncode, 1, text)
            self.assertIn("docs/results.md: a comment", run.stderr)

    def test_broken_files_are_refused(self):
        for figures in ({}, [{"name": "force"}], [FIGURE, FIGURE], [FIGURE | {"value": 1}],
                        [FIGURE | {"value": "a | b"}], [FIGURE | {"name": "a b"}]):
            self.put_figures(figures)
            run = self.run_script("--check")
            self.assertEqual(run.returncode, 1, figures)
            self.assertIn("docs/figures.json", run.stderr)

    def test_new_values_are_stored_with_the_commit(self):
        git = ["git", "-C", self.root, "-c", "user.name=t", "-c", "user.email=t@localhost"]
        subprocess.run([*git, "init", "-q"], check=True, timeout=60)
        subprocess.run([*git, "commit", "-q", "--allow-empty", "-m", "First"], check=True, timeout=60)
        head = subprocess.run([*git, "rev-parse", "--short=7", "HEAD"], capture_output=True, text=True, check=True,
                              timeout=60).stdout.strip()
        self.put("docs/results.md", "<!-- figure: depth -->?<!-- /figure -->\n")
        run = self.run_script("--set", "force=1.5 N", "--add", "depth=3 mm", "--command", "tests/study/soak")
        self.assertEqual(run.returncode, 0, run.stderr)
        force, depth = json.loads(self.get("docs/figures.json"))
        self.assertEqual((force["value"], force["commit"], force["command"]), ("1.5 N", head, "scripts/report"))
        self.assertEqual((depth["value"], depth["commit"], depth["command"]), ("3 mm", head, "tests/study/soak"))
        self.assertEqual(self.get("docs/results.md"), "<!-- figure: depth -->3 mm<!-- /figure -->\n")
        self.assertIn("no figure 'width'", self.run_script("--set", "width=1").stderr)


if __name__ == "__main__":
    unittest.main()
