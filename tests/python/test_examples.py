#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples run as they stand, and tell what they are said to."""

import os
import re
import subprocess
import sys
import unittest

from small_scene import PATIENCE, ROOT, InTemporaryFolder

from acus import engine  # noqa: E402

EXAMPLES = os.path.join(ROOT, "client", "python", "examples")


class Examples(InTemporaryFolder):
    def run_example(self, name, *arguments, stderr="$"):
        environment = {**os.environ, "PYTHONPATH": os.path.join(ROOT, "client", "python")}
        done = subprocess.run([sys.executable, os.path.join(EXAMPLES, name), *arguments], cwd=self.folder, text=True,
                              env=environment, capture_output=True, timeout=4 * PATIENCE, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stderr, "^" + stderr)
        return done.stdout

    def test_first_insertion(self):
        text = self.run_example("first_insertion.py")
        self.assertIn("puncture of 'phantom' at 1.00 N", text)
        self.assertTrue("no picture" in text or os.path.getsize(self.path("first_insertion.png")) > 5000)

    @unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
    def test_first_force(self):
        with open(os.path.join(EXAMPLES, "first_force.py"), encoding="utf-8") as file:
            told = "print(max(each.base_force @ -needle.axis for each in felt[:1500]))\n"
            script = self.write("first_force.py", 'import matplotlib\nmatplotlib.use("agg")\n' + file.read() + told)
        self.assertAlmostEqual(float(self.run_example(script)), 1.0, delta=0.01)  # N: f_p
        self.assertGreater(os.path.getsize(self.path("force.png")), 5000)

    def test_steering(self):
        found = re.search(r"came to (\S+) mm from the target, (\S+) mm beside", self.run_example("steering.py"))
        self.assertLess(float(found[1]), 1.0)  # 0.39
        self.assertGreater(float(found[2]), 5.0)  # 5.8

    @unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
    def test_sweep(self):
        rows = [line.split() for line in self.run_example("sweep.py", stderr=r".* 6/6 done, 0 failed").splitlines()[1:]]
        self.assertEqual(len(rows), 6)
        ways = {(float(stiffness), float(puncture)): float(way) for stiffness, puncture, way, _ in rows}
        for stiffness in (5, 10, 20):
            self.assertGreater(ways[stiffness, 1.0], ways[stiffness, 0.5])
        self.assertGreater(ways[5, 1.0], ways[20, 1.0])

    @unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
    def test_spread(self):
        with open(os.path.join(EXAMPLES, "spread.py"), encoding="utf-8") as file:
            script = self.write("spread.py", file.read().replace("1000)).run()", "8)).run()"))
        self.run_example(script, stderr=r".* 8/8 done, 0 failed")
        for picture in ("spread.png", "sensitivity.png"):
            self.assertGreater(os.path.getsize(self.path(picture)), 5000)

    @unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
    def test_around_obstacle(self):
        with open(os.path.join(EXAMPLES, "around_obstacle.py"), encoding="utf-8") as file:
            script = self.write("around.py", file.read().replace("cases=400)", "cases=20, samples=2, speed=0.2)"))
        self.assertRegex(self.run_example(script, stderr="coarse search: "), r"plan  succeeds .* to obstacle mm")
        for name in ("plan.png", "plan.yaml", "plan.csv", "plan.acus"):
            self.assertGreater(os.path.getsize(self.path(name)), 1000)

    @unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
    def test_brachytherapy(self):
        with open(os.path.join(EXAMPLES, "brachytherapy.py"), encoding="utf-8") as file:
            script = self.write("brachytherapy.py", file.read().replace("orders=12)", "orders=1, rounds=0, samples=1, speed=0.2)")
                                .replace("depths =", "scene['rate'] = 50\ndepths ="))
        text = self.run_example(script, stderr="orders: 1 implants of 20 seeds")
        straight, planned = map(float, re.search(r"straight: (\S+) mm, planned: (\S+) mm", text).groups())
        self.assertLess(planned, 0.5 * straight)

    @unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
    def test_closed_loop(self):
        text = self.run_example("closed_loop.py")
        self.assertGreater(float(re.search(r"as planned: (\S+) mm", text)[1]), 3.0)  # 3.47
        self.assertLess(float(re.search(r"corrected: (\S+) mm", text)[1]), 0.5)  # 0.16

    def test_control_loop(self):
        text = self.run_example("control_loop.py", "1")
        self.assertRegex(text, r"\d+ turns for \d+ ticks, \d+ lost")
        self.assertRegex(text, r"force in the last tenth: -?\d\.\d+ N")

    def test_every_example_is_tested(self):
        tested = {name.removeprefix("test_") + ".py" for name in dir(self) if name.startswith("test_")}
        self.assertEqual({name for name in os.listdir(EXAMPLES) if name.endswith(".py")} - tested, set())


if __name__ == "__main__":
    unittest.main()
