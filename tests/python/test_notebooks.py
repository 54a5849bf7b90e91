#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The notebooks run from top to bottom, with fewer cases than they show."""

import importlib.util
import os
import re
import unittest

from small_scene import PATIENCE, ROOT, InTemporaryFolder

from acus import engine  # noqa: E402

NOTEBOOKS = os.path.join(ROOT, "client", "python", "examples", "notebooks")
FEWER = ((r", 64\)", ", 8)"), (r"case\(17\)", "case(7)"), (r"cases=\d+", "cases=20, samples=2, speed=0.2"))


@unittest.skipUnless(all(map(importlib.util.find_spec, ("nbclient", "ipykernel"))), "SKIPPED: python3-nbclient or python3-ipykernel is missing")
@unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
class Notebooks(InTemporaryFolder):
    def run_notebook(self, name):
        """The notebook as run: its outputs."""
        import nbclient  # pylint: disable=import-outside-toplevel  # where they are there
        import nbformat  # pylint: disable=import-outside-toplevel
        notebook = nbformat.read(os.path.join(NOTEBOOKS, name + ".ipynb"), 4)
        nbformat.validate(notebook)
        for cell in notebook.cells:
            self.assertTrue(cell.cell_type != "code" or cell.execution_count, f"{name}: it is kept with its outputs")
            for pattern, fewer in FEWER if cell.cell_type == "code" else ():
                cell.source = re.sub(pattern, fewer, cell.source)
        environment = {**os.environ, "PYTHONPATH": os.path.join(ROOT, "client", "python"), "HOME": self.folder}
        client = nbclient.NotebookClient(notebook, timeout=4 * PATIENCE, kernel_name="python3", resources={"metadata": {"path": self.folder}})
        client.execute(env=environment)
        return [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]

    def pictures(self, outputs):
        return sum("image/png" in output.get("data", {}) for output in outputs)

    def text(self, outputs):
        return "".join(output.get("text", "") for output in outputs)

    def test_first_insertion(self):
        outputs = self.run_notebook("first_insertion")
        self.assertIn("puncture of 'phantom' at 1.00 N", self.text(outputs))
        self.assertEqual(self.pictures(outputs), 2)

    def test_study(self):
        outputs = self.run_notebook("study")
        self.assertIn("8 cases, 0 kinds of failures", self.text(outputs))
        self.assertEqual(self.pictures(outputs), 2)

    def test_plan(self):
        outputs = self.run_notebook("plan")
        self.assertIn("to obstacle mm", self.text(outputs))
        self.assertEqual(self.pictures(outputs), 2)

    def test_every_notebook_is_tested(self):
        tested = {name.removeprefix("test_") + ".ipynb" for name in dir(self) if name.startswith("test_")}
        self.assertEqual(set(os.listdir(NOTEBOOKS)) - tested, set())


if __name__ == "__main__":
    unittest.main()
