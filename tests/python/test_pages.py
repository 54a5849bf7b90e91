#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The programs that the pages on Python show run as they stand."""

import os
import re
import subprocess
import sys
import unittest

from small_scene import PATIENCE, ROOT, InTemporaryFolder

from acus import engine  # noqa: E402


class Pages(InTemporaryFolder):
    def test_what_the_pages_show(self):
        self.run_page("python.md", 3)
        self.assertGreater(os.path.getsize(self.path("force.png")), 5000)

    @unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
    def test_what_the_page_of_studies_shows(self):
        self.run_page("studies.md", 3)

    @unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
    def test_what_the_page_of_fits_shows(self):
        self.run_page("fitting.md", 1)

    def run_page(self, name, least):
        with open(os.path.join(ROOT, "docs", name), encoding="utf-8") as file:
            blocks = re.findall(r"```python\n(.*?)```", file.read(), re.DOTALL)
        self.assertGreaterEqual(len(blocks), least)
        for block in blocks:
            script = self.write("block.py", block)
            environment = {**os.environ, "PYTHONPATH": os.path.join(ROOT, "client", "python"), "MPLBACKEND": "agg"}
            done = subprocess.run([sys.executable, script], cwd=self.folder, text=True, env=environment,
                                  capture_output=True, timeout=4 * PATIENCE, check=False)
            self.assertEqual(done.returncode, 0, block + done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
