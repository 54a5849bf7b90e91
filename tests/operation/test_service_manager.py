#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Plays the service manager: a server tells it when it is ready, what it does, that it lives, and that it ends."""

import ctypes
import os
import signal
import socket
import time
import unittest

from running_server import PATIENCE, SCENE, WithServer

WATCHDOG = 0.2  # s that the manager says it waits for a sign of life
PTRACE_DETACH, PTRACE_SEIZE, PTRACE_INTERRUPT = 17, 0x4206, 0x4207


def ptrace(request, thread):
    libc = ctypes.CDLL(None, use_errno=True)
    libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
    if libc.ptrace(request, thread, None, None) != 0:
        error = ctypes.get_errno()
        raise OSError(error, os.strerror(error))


def thread_named(process, name):
    folder = f"/proc/{process}/task"
    for thread in os.listdir(folder):
        with open(f"{folder}/{thread}/comm", encoding="utf-8") as file:
            if file.read().strip() == name:
                return int(thread)
    raise AssertionError(f"no thread is called {name}")


class Notifications(WithServer):
    def setUp(self):
        super().setUp()
        self.manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.manager.close)
        self.manager.bind(self.path("notify"))
        self.manager.settimeout(PATIENCE)

    def start_managed(self, *options):
        environment = dict(os.environ, NOTIFY_SOCKET=self.path("notify"), WATCHDOG_USEC=str(int(1e6 * WATCHDOG)))
        environment.pop("WATCHDOG_PID", None)
        return self.start(*options, env=environment)

    def lines(self):
        """Of the next datagram."""
        return self.manager.recv(8192).decode().strip().split("\n")

    def wait_for(self, line):
        """What came before the line, which comes."""
        deadline = time.monotonic() + PATIENCE
        before = []
        while time.monotonic() < deadline:
            before += self.lines()
            if line in before:
                return before
        raise AssertionError(f"{line} did not come, but {before}")

    def signs_of_life(self):
        """That wait to be read."""
        count = 0
        self.manager.setblocking(False)
        try:
            while True:
                count += self.lines().count("WATCHDOG=1")
        except BlockingIOError:
            return count
        finally:
            self.manager.settimeout(PATIENCE)

    def test_the_life_of_a_server(self):
        for options, status in (([], "scene 'small', 200 Hz"), (["--lockstep"], "scene 'small', 200 Hz, lockstep")):
            server = self.start_managed(*options)
            self.assertEqual(self.lines(), ["READY=1", "STATUS=" + status])
            self.assertEqual(self.client().ask("hello")["scene"], "small")
            for _ in range(3):
                self.wait_for("WATCHDOG=1")
            server.send_signal(signal.SIGTERM)
            self.wait_for("STOPPING=1")
            self.assertEqual(server.wait(PATIENCE), 0)

    def test_shutdown_tells_that_it_stops(self):
        server = self.start_managed()
        self.client().ask("shutdown")
        self.wait_for("STOPPING=1")
        self.assertEqual(server.wait(PATIENCE), 0)

    def test_the_status_follows_the_server(self):
        self.start_managed()
        client = self.client()
        client.ask("pause")
        self.wait_for("STATUS=scene 'small', 200 Hz, paused")
        client.ask("load", text=SCENE.format(name='"other\\nSTOPPING=1"').replace("rate: 200", "rate: 300"))
        told = self.wait_for("STATUS=scene 'other STOPPING=1', 300 Hz, paused")
        self.assertNotIn("STOPPING=1", told)

    def test_a_paused_server_and_one_in_a_long_step_live(self):
        self.start_managed()
        self.client().ask("pause")
        self.signs_of_life()
        for _ in range(3):
            self.wait_for("WATCHDOG=1")

    def test_one_in_a_long_step_lives(self):
        self.start_managed("--lockstep")
        self.client().send("step", ticks=100000)
        for _ in range(3):
            self.wait_for("WATCHDOG=1")

    def test_a_simulation_thread_that_hangs_is_not_kept_alive_by_the_sockets(self):
        server = self.start_managed()
        client = self.client()
        client.ask("hello")
        thread = thread_named(server.pid, "acus-simulation")
        try:
            ptrace(PTRACE_SEIZE, thread)
        except PermissionError as error:
            print(f"SKIPPED: threads cannot be stopped here: {error}")
            self.skipTest("ptrace")
        ptrace(PTRACE_INTERRUPT, thread)
        os.waitpid(thread, getattr(os, "__WALL", 0x40000000))
        time.sleep(WATCHDOG)
        for _ in range(2):  # the sockets' thread wakes up, and tells of the last turns
            client.ask("hello")
        self.signs_of_life()
        for _ in range(3):
            time.sleep(WATCHDOG)
            self.assertEqual(client.ask("hello")["scene"], "small")
        self.assertEqual(self.signs_of_life(), 0)
        ptrace(PTRACE_DETACH, thread)
        self.wait_for("WATCHDOG=1")


if __name__ == "__main__":
    unittest.main()
