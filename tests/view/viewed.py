# SPDX-License-Identifier: GPL-3.0-or-later
"""A gateway, with or without a server of its own, for tests."""

import os
import subprocess
import tempfile
import unittest

PROGRAMS = os.environ["ACUS_PROGRAMS"]
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PATIENCE = 20.0  # s, for what should take a moment


class WithGateway(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="acus-view-test-")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def start(self, program, *arguments):
        process = subprocess.Popen([os.path.join(PROGRAMS, program), *arguments], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=dict(os.environ, TMPDIR=self.folder))
        self.addCleanup(self.end, process)
        return process

    def end(self, process):
        if process.poll() is None:
            process.terminate()
        try:
            process.wait(PATIENCE)
        finally:
            process.kill()
            process.stdout.close()
            process.stderr.close()

    def view(self, *arguments):
        """The gateway's process and the URL that it prints."""
        process = self.start("acus-view", "--no-browser", *arguments)
        url = process.stdout.readline().strip()
        self.assertTrue(url.startswith("http://127.0.0.1:"), url or process.stderr.read())
        return process, url

    def endpoints(self):
        return [f"ipc://{self.folder}/commands", f"ipc://{self.folder}/states"]

    def serve(self, scene, *options):
        commands, states = self.endpoints()
        return self.start("acus-server", scene, "--commands", commands, "--states", states, *options)


def scene(name):
    return os.path.join(ROOT, "scenes", name + ".yaml")
