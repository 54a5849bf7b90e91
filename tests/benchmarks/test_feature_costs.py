# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that tests/study/feature-costs (the first argument) can still make every scene that it measures, that acus-bench
(the second) runs them, and what is said of wrong uses. Nothing is measured."""

import importlib.machinery
import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest

BENCH, SCRIPT = sys.argv.pop(), sys.argv.pop()


def load():
    sys.dont_write_bytecode = True  # nothing is left beside the script
    loader = importlib.machinery.SourceFileLoader("feature_costs", SCRIPT)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("feature_costs", loader))
    loader.exec_module(module)
    return module


def run(*command, **environment):
    options = {"env": {**os.environ, **environment}, "capture_output": True, "text": True, "timeout": 60}
    return subprocess.run(command, check=False, **options)


class FeatureCosts(unittest.TestCase):
    def test_every_edit_fits_and_gives_a_sound_scene(self):
        script = load()
        with tempfile.TemporaryDirectory() as folder:
            for name, with_, without in script.FEATURES:
                for edits in (with_, without):
                    with self.subTest(name):
                        variant = script.Variant.of(folder, edits)
                        limits = ["--ticks", "6", "--no-calibration", "--quiet"]
                        done = run(BENCH, variant.scene, variant.trajectory, *limits)
                        self.assertEqual(done.returncode, 0, done.stderr)

    def test_every_feature_changes_the_scene(self):
        script = load()
        for name, with_, without in script.FEATURES:
            self.assertNotEqual(script.edited(with_), script.edited(without), name)

    def test_an_unknown_feature_is_an_error_that_lists_the_known(self):
        done = run("/usr/bin/python3", SCRIPT, "wings", "--no-build")
        self.assertEqual(done.returncode, 1)
        self.assertIn("'wings' is in no feature's name", done.stderr)
        self.assertIn("second needle", done.stderr)

    def test_missing_programs_are_an_error_with_the_remedy(self):
        with tempfile.TemporaryDirectory() as empty:
            command = ["/usr/bin/python3", SCRIPT, "gravity", "--no-build", "--release", empty]
            self.assertIn("apt-get install valgrind", run(*command, PATH=empty).stderr)
            valgrind = os.path.join(empty, "valgrind")
            with open(valgrind, "w", encoding="ascii"):
                os.chmod(valgrind, 0o755)
            self.assertIn("acus-bench is missing; leave --no-build out", run(*command, PATH=empty).stderr)


if __name__ == "__main__":
    unittest.main()
