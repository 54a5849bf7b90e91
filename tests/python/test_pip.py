#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What pip installs from a checkout: the package with the scenes, which says how to get a server."""

import importlib.util
import os
import shutil
import subprocess
import sys
import unittest

from small_scene import PATIENCE, ROOT, InTemporaryFolder


@unittest.skipUnless(all(map(importlib.util.find_spec, ("pip", "setuptools", "wheel"))), "SKIPPED: pip, setuptools or wheel is missing")
class Installed(InTemporaryFolder):
    def test_it_has_the_scenes_and_says_how_to_get_a_server(self):
        copy = self.path("checkout")
        for folder in (os.path.join("client", "python"), "scenes"):
            shutil.copytree(os.path.join(ROOT, folder), os.path.join(copy, folder), ignore=shutil.ignore_patterns("__pycache__", "pictures"))
        before, target = self.files_in(copy), self.path("site")
        subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-build-isolation", "--no-deps", "--target", target,
                        os.path.join(copy, "client", "python")], check=True, capture_output=True, timeout=2 * PATIENCE)
        self.assertEqual(self.files_in(copy), before)  # nothing is left
        shutil.rmtree(copy)
        self.assertIn("brachytherapy.yaml", self.run_installed(target, "print(acus.find_scene('brachytherapy'))"))
        self.assertIn("prostate.msh", os.listdir(os.path.join(target, "acus", "scenes", "meshes")))
        self.assertRegex(self.run_installed(target, "acus.find_scene('nowhere')", 1), r"no scene 'nowhere': .* there are .*biopsy.*, through")
        self.assertRegex(self.run_installed(target, "acus.find_server()", 1), r"this package is Python alone: build .* \$ACUS_SERVER")

    def files_in(self, folder):
        return sorted(os.path.join(where, name) for where, folders, files in os.walk(folder) for name in [*folders, *files])

    def run_installed(self, target, program, status=0):
        """Its output."""
        environment = {"PYTHONPATH": target, "PATH": self.folder, "HOME": self.folder}
        done = subprocess.run([sys.executable, "-c", "import acus; " + program], env=environment, cwd=self.folder, text=True, timeout=PATIENCE,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        self.assertEqual(done.returncode, status, done.stdout)
        return done.stdout


if __name__ == "__main__":
    unittest.main()
