# SPDX-License-Identifier: GPL-3.0-or-later
"""A gateway, with or without a server of its own, for tests."""

import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tests", "operation"))

from running_server import WithServer  # noqa: E402

PATIENCE = 20.0  # s, for what should take a moment


class WithGateway(WithServer):
    """Programs are asked to end, so that a gateway takes its server along; what they leave goes with the folder."""

    def launch(self, program, *arguments):
        return self.start(program=program, arguments=list(arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, env=dict(os.environ, TMPDIR=self.folder))

    def end(self, server):
        if server.poll() is None:
            server.terminate()
        try:
            server.wait(PATIENCE)
        finally:
            super().end(server)

    def view(self, *arguments):
        """The gateway's process and the URL that it prints."""
        process = self.launch("acus-view", "--no-browser", *arguments)
        url = process.stdout.readline().strip()
        self.assertTrue(url.startswith("http://127.0.0.1:"), url or process.stderr.read())
        return process, url

    def serve(self, scene, *options):
        return self.launch("acus-server", scene, "--commands", self.commands, "--states", self.states, *options)


def scene(name):
    return os.path.join(ROOT, "scenes", name + ".yaml")
