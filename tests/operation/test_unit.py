#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""systemd reads the unit without a complaint, also with what docs/operating.md adds to it, and says how exposed the
service is."""

import os
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
UNIT = os.path.join(ROOT, "cmake", "acus-server@.service")
OPERATING = os.path.join(ROOT, "docs", "operating.md")
SCENE = os.path.join(ROOT, "scenes", "insertion_pullback.yaml")
SERVER = os.path.join(os.environ["ACUS_PROGRAMS"], "acus-server")
MOST_EXPOSED = 2.0  # of 10; measured 1.4 with systemd 252


def text_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def documented_additions():
    """The blocks of docs/operating.md that begin with [Service]."""
    blocks = re.findall(r"^    \[Service\]\n(?:    .*\n)+", text_of(OPERATING), re.MULTILINE)
    return [block.replace("    ", "") for block in blocks]


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
        # The program of this build, instead of an installed one, and no manual page.
        text = text_of(UNIT).replace("ExecStart=acus-server", "ExecStart=" + SERVER).replace("Documentation=man:", "#")
        self.unit = os.path.join(folder.name, "acus-server@through.service")
        self.write(text)

    def write(self, text):
        with open(self.unit, "w", encoding="utf-8") as file:
            file.write(text)

    def test_systemd_has_nothing_to_complain_of(self):
        done = analyze("verify", self.unit)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_systemd_has_nothing_to_complain_of_in_what_the_document_adds(self):
        additions = documented_additions()
        self.assertEqual(len(additions), 2)
        text = text_of(self.unit)
        for addition in additions:
            self.write(text + "\n" + addition)
            done = analyze("verify", self.unit)
            self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_what_clients_can_make_it_take_is_bounded(self):
        bounds = dict(re.findall(r"^(MemoryMax|TasksMax|LimitNOFILE)=(\S+)$", text_of(UNIT), re.MULTILINE))
        self.assertEqual(set(bounds), {"MemoryMax", "TasksMax", "LimitNOFILE"})
        self.assertNotIn("infinity", bounds.values())

    def test_the_service_is_confined(self):
        done = analyze("security", "--offline=true", "--no-pager", self.unit)
        exposure = re.search(r"Overall exposure level for .*: ([0-9.]+)", done.stdout + done.stderr)
        if not exposure:
            print("SKIPPED: this systemd-analyze reads no unit that is not installed")
            self.skipTest("systemd-analyze security --offline")
        self.assertLessEqual(float(exposure[1]), MOST_EXPOSED)


class Statuses(unittest.TestCase):
    def test_a_recording_in_the_way_is_not_tried_again(self):
        prevented = re.search(r"^RestartPreventExitStatus=(.*)$", text_of(UNIT), re.MULTILINE)[1].split()
        with tempfile.TemporaryDirectory(prefix="acus-") as folder:
            recording = os.path.join(folder, "run.acus")
            open(recording, "w", encoding="utf-8").close()
            endpoints = [f"--{name}=ipc://{folder}/{name}" for name in ("commands", "states")]
            command = [SERVER, SCENE, *endpoints, "--ticks", "1", "--record", recording]
            done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
        self.assertIn(recording, done.stderr)
        self.assertIn(str(done.returncode), prevented)


class Document(unittest.TestCase):
    def test_keys_are_read_where_systemd_puts_them(self):
        text = text_of(OPERATING)
        credentials = set(re.findall(r"LoadCredential=([\w.]+):", text))
        self.assertTrue(credentials)
        self.assertEqual(set(re.findall(r"/run/credentials/acus-server@NAME\.service/([\w.]+)", text)), credentials)


if __name__ == "__main__":
    unittest.main()
