# SPDX-License-Identifier: GPL-3.0-or-later
"""scripts/bench --recorded (the folder of scripts is the only argument), in a repository of its own."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = sys.argv.pop()
HEAD = "date,commit,processor,kernels,scene,tick_p50_to_calibration,tick_p99_to_p50,state_hash,change\n"


class Recorded(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = folder.name
        for name in ("scripts", "server/engine", "tests/benchmarks", "docs"):
            os.makedirs(os.path.join(self.root, name))
        for name in ("bench", "lib.sh"):
            shutil.copy(os.path.join(SCRIPTS, name), os.path.join(self.root, "scripts"))
        self.git("init", "--quiet")
        self.write("tests/benchmarks/history.csv", HEAD)

    def git(self, *arguments):
        name = ["-c", "user.name=A", "-c", "user.email=a@b"]
        done = subprocess.run(["git", *name, *arguments], cwd=self.root, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    def write(self, name, text):
        with open(os.path.join(self.root, name), "a", encoding="utf-8") as file:
            file.write(text)

    def commit(self, name):
        self.write(name, "x\n")
        self.git("add", ".")
        self.git("commit", "--quiet", "-m", name)
        return self.git("rev-parse", "--short", "HEAD")

    def record(self, commit):
        self.write("tests/benchmarks/history.csv", f"2026-01-01,{commit},P,v3,cube_1000,1,1,0,change\n")

    def recorded(self):
        done = subprocess.run(["scripts/bench", "--recorded"], cwd=self.root, capture_output=True, text=True, check=False)
        return done.returncode, done.stderr

    def test_a_change_of_the_engine_needs_a_line_of_its_commit_or_of_one_after_it(self):
        first = self.commit("server/engine/a.cpp")
        status, told = self.recorded()
        self.assertEqual(status, 6)
        self.assertIn(f"commit {first} touches server/engine and has no line in tests/benchmarks/history.csv", told)
        self.assertIn("scripts/bench --record", told)
        self.record(first)
        self.assertEqual(self.recorded(), (0, ""))
        self.commit("docs/b.md")
        self.assertEqual(self.recorded(), (0, ""))
        second = self.commit("server/engine/a.cpp")
        self.assertEqual(self.recorded()[0], 6)
        self.record(f"{second}-dirty")
        self.assertEqual(self.recorded()[0], 6)
        self.record(self.commit("docs/b.md"))
        self.assertEqual(self.recorded(), (0, ""))


if __name__ == "__main__":
    unittest.main()
