# SPDX-License-Identifier: MIT
"""An acus-server of one's own, as a child process."""

import os
import shutil
import subprocess
import tempfile
import time
import weakref

import zmq

from .client import Client
from .errors import ProgramNotFound, ServerFailed
from .guard import Guard
from .link import Link
from .programs import find_server, scene_path

STARTING = 60.0  # s at most until it listens; a large scene takes a while to load
ENDING = 10.0  # s after SIGTERM
LOOK = 0.05  # s between two looks at a server that starts
LONGEST_PATH = 107 - len("/commands")  # bytes of an ipc path


class Server:
    """Starts acus-server with a scene, on ipc sockets in a folder of its own, and waits until it listens.

    `scene` is a path, the name of an installed scene, or a Scene. In lockstep ticks run when a client asks, else in
    real time. `rate` (Hz) replaces the scene's own; `options` are further ones of acus-server; `keys` those with which
    its clients connect. Raises ServerFailed with what the server says if it cannot start. It ends with end(), with the
    `with` block, with the object or with this program, whatever ends that.
    """

    def __init__(self, scene, *, lockstep=False, rate=None, options=(), keys=None, program=None, timeout=STARTING):
        self.folder = new_folder()
        self.commands, self.states = (f"ipc://{self.folder}/{name}" for name in ("commands", "states"))
        self._keys = keys
        self._log_path = os.path.join(self.folder, "log")
        self._process = None
        try:
            command = [find_server(program), self._scene_file(scene), "--commands", self.commands, "--states",
                       self.states, *(["--lockstep"] if lockstep else []),
                       *(["--rate", repr(float(rate))] if rate else []), *self._mesh_folders(scene), *options]
            with open(self._log_path, "wb") as log:
                # In a session of its own: Ctrl-C is for the program that started it, which ends it.
                self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                                 start_new_session=True)
            guard = Guard(self._process.pid, self.folder)
        except BaseException:
            if self._process:
                self._process.kill()
            shutil.rmtree(self.folder, ignore_errors=True)
            raise
        self._finalizer = weakref.finalize(self, end_process, self._process, self.folder, guard)
        try:
            self._wait_until_it_listens(time.monotonic() + timeout)
        except BaseException:
            self.end()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()

    @property
    def pid(self):
        return self._process.pid

    @property
    def running(self):
        return self._process.poll() is None

    @property
    def log(self):
        """What the server has written so far; also after its end."""
        if os.path.exists(self._log_path):
            with open(self._log_path, encoding="utf-8", errors="replace") as file:
                self._log = file.read()
        return self._log

    def client(self, **settings):
        """A Client of this server; arguments are those of Client but for the endpoints."""
        return Client(self.commands, self.states, **{"keys": self._keys, **settings})

    def end(self):
        """Its exit status; may be called again."""
        self.log  # pylint: disable=pointless-statement  # the file goes with the folder
        self._finalizer()
        return self._process.returncode

    _log = ""

    def _scene_file(self, scene):
        text = getattr(scene, "text", None)
        if not text:
            return known_file(scene)
        path = os.path.join(self.folder, "scene.yaml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text())
        return path

    @staticmethod
    def _mesh_folders(scene):
        """What a client loads later may lie beside the file that a Scene was read from."""
        folder = getattr(scene, "folder", None)
        return ["--scenes", folder] if folder else []

    def _wait_until_it_listens(self, deadline):
        context = zmq.Context()
        try:
            link = Link(context, zmq.DEALER, self.commands, self._keys)
            while not link.connected() and not link.refused():
                if not self.running:
                    raise ServerFailed(f"acus-server ended with status {self._process.returncode}: {self.log.strip()}",
                                       self._process.returncode, self.log)
                if time.monotonic() > deadline:
                    raise ServerFailed("acus-server did not listen in time", log=self.log)
                link.monitor.poll(1000 * LOOK)
        finally:
            context.destroy(linger=0)


def new_folder():
    """Short enough for a socket in it."""
    folder = tempfile.mkdtemp(prefix="acus-")
    if len(os.fsencode(folder)) <= LONGEST_PATH:
        return folder
    os.rmdir(folder)
    return tempfile.mkdtemp(prefix="acus-", dir="/tmp")


def end_process(process, folder, guard):
    guard.end()
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(ENDING)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    shutil.rmtree(folder, ignore_errors=True)


def known_file(scene):
    """Of a scene by path or name; a name that is known nowhere here is left to the server."""
    try:
        return scene_path(scene)
    except ProgramNotFound:
        return os.fspath(scene)
