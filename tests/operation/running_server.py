# SPDX-License-Identifier: GPL-3.0-or-later
"""A server for a test, with a small scene, on sockets of its own below a temporary folder."""

import os
import subprocess
import tempfile
import time
import unittest

import msgpack
import zmq

PROGRAMS = os.environ["ACUS_PROGRAMS"]  # folder of acus-server
PATIENCE = 60  # s, for what takes milliseconds on a machine that is not busy

SCENE = """\
acus_scene: 1
name: {name}
rate: 200
tissue:
  mesh:
    box: {{size: [0.1, 0.1, 0.1], cells: [3, 3, 3]}}
  fixed:
    - box: {{max: [.inf, .inf, -0.05]}}
needle_contact: {{enabled: false}}  # one reaches into the other
needles:
  - {{name: left, length: 0.1, beams: 5, base: {{position: [0, 0, 0.5]}}}}
  - {{name: right, length: 0.1, beams: 5, base: {{position: [0.03, 0, 0.5]}}}}
"""


class WithServer(unittest.TestCase):
    """Tests that start servers; all of them have ended, and the folder is gone, when the test is over."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="acus-")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.context = zmq.Context()
        self.addCleanup(self.context.destroy, linger=0)
        self.scene = self.write("scene.yaml", SCENE.format(name="small"))
        self.commands = "ipc://" + self.path("commands")
        self.states = "ipc://" + self.path("states")

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)

    def start(self, *options, program="acus-server", arguments=None, **settings):
        """Starts a program that is ended with the test."""
        arguments = arguments or [self.scene, "--commands", self.commands, "--states", self.states]
        server = subprocess.Popen([os.path.join(PROGRAMS, program), *arguments, *options], **settings)
        self.addCleanup(self.end, server)
        return server

    def end(self, server):
        if server.poll() is None:
            server.kill()
        for stream in (server.stdin, server.stdout, server.stderr):
            if stream:
                stream.close()
        server.wait(PATIENCE)

    def client(self):
        socket = self.context.socket(zmq.DEALER)
        self.addCleanup(socket.close, linger=0)
        socket.connect(self.commands)
        return Client(socket)


class Client:
    """A connection to the commands socket."""

    def __init__(self, socket):
        self.socket = socket
        self.seq = 0

    def send(self, kind, **fields):
        self.seq += 1
        self.socket.send(msgpack.packb({"v": 2, "type": kind, "seq": self.seq, **fields}))

    def ask(self, kind, **fields):
        """The answer to a request."""
        self.send(kind, **fields)
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            if self.socket.poll(1000):
                answer = msgpack.unpackb(self.socket.recv())
                if answer.get("seq") == self.seq and "rejected" not in answer or answer.get("rejected") == kind:
                    return answer
        raise AssertionError(f"no answer to {kind}")
