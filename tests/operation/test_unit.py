#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""systemd reads the unit without a complaint, and says how exposed the service is."""

import os
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
UNIT = os.path.join(ROOT, "cmake", "acus-server@.service")
SERVER = os.path.join(os.environ["ACUS_PROGRAMS"], "acus-server")
MOST_EXPOSED = 2.0  # of 10; measured 1.4 with systemd 252


def analyze(*arguments):
    command = ["systemd-analyze", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


class Unit(unittest.TestCase):
    def setUp(self):
        if shutil.which("systemd-analyze") is None:
            print("SKIPPED: systemd-analyze is not here")
            self.skipTest("systemd-analyze")
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        with open(UNIT, encoding="utf-8") as file:
            text = file.read()
        # The program of this build, instead of an installed one, and no manual page.
        text = text.replace("ExecStart=acus-server", "ExecStart=" + SERVER).replace("Documentation=man:", "#")
        self.unit = os.path.join(folder.name, "acus-server@through.service")
        with open(self.unit, "w", encoding="utf-8") as file:
            file.write(text)

    def test_systemd_has_nothing_to_complain_of(self):
        done = analyze("verify", self.unit)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_the_service_is_confined(self):
        done = analyze("security", "--offline=true", "--no-pager", self.unit)
        exposure = re.search(r"Overall exposure level for .*: ([0-9.]+)", done.stdout + done.stderr)
        if not exposure:
            print("SKIPPED: this systemd-analyze reads no unit that is not installed")
            self.skipTest("systemd-analyze security --offline")
        self.assertLessEqual(float(exposure[1]), MOST_EXPOSED)


if __name__ == "__main__":
    unittest.main()
