#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs acus-top beside servers: one page as text, and the pages that a terminal shows."""

import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
import unittest

import msgpack
import pyte
import zmq

from running_server import PATIENCE, SCENE, WithServer

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TOP = os.path.join(ROOT, "client", "top")
sys.path.insert(0, os.path.join(ROOT, "client", "python"))

from acus.apps import top_page  # noqa: E402


class Names(unittest.TestCase):
    def test_flags_have_names(self):
        self.assertEqual(top_page.flags_text(0), "none")
        self.assertEqual(top_page.flags_text(1 << 5 | 1 << 10 | 1 << 30), "not_finite, step_limited, 0x40000000")


class Once(WithServer):
    def top(self, *arguments):
        command = [TOP, "--commands", self.commands, "--states", self.states, *arguments]
        return subprocess.run(command, capture_output=True, text=True, timeout=2 * PATIENCE, check=False)

    def page(self):
        done = self.top("--once", "--timeout", str(PATIENCE))
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def row(self, page, needle):
        return re.split(r"  +", next(line for line in page.split("\n") if line.startswith(needle + " ")))

    def test_a_page_of_a_running_server(self):
        self.start()
        client = self.client()
        client.ask("acquire", needles=["left"])
        page = self.page()
        self.assertIn("scene 'small'\n", page)
        self.assertRegex(page, r"rate +\d+\.\d of 200 Hz; late \d+\.\d of 1,000 ticks; \d+ deadlines skipped")
        for name in ("began", "ended", "computed"):
            self.assertRegex(page, name + r"( +\d+\.\d{3}){3}")
        self.assertRegex(page, r"at most \d+ rows, \d+ iterations, \d+ sweeps; residual .* N, imbalance .* of .* N")
        self.assertRegex(page, r"flags +none")
        self.assertIn("stats", page)
        columns = re.split(r"  +", next(line for line in page.split("\n") if line.startswith("needle ")))
        self.assertEqual(columns, top_page.COLUMNS)
        left, right = self.row(page, "left"), self.row(page, "right")
        self.assertEqual(left[1:4], ["yes", "free", "0.0"])
        self.assertEqual(right[1:4], ["no", "free", "0.0"])
        self.assertEqual(left[-1], "none")

    def test_a_paused_server_and_one_in_lockstep(self):
        server = self.start()
        self.client().ask("pause")
        self.assertIn("scene 'small', paused", self.page())
        self.end(server)
        self.start("--lockstep")
        page = self.page()
        self.assertIn("scene 'small', lockstep", page)
        self.assertEqual(self.row(page, "left"), ["left", "no"] + ["-"] * (len(top_page.COLUMNS) - 2))

    def test_a_name_moves_no_cursor(self):
        self.write("scene.yaml", SCENE.format(name='"evil\\e[2Jname"'))
        self.start()
        page = self.page()
        self.assertIn("scene 'evil?[2Jname'", page)
        self.assertNotIn("\x1b", page)

    def test_a_reader_that_is_gone_is_no_trouble(self):
        self.start()
        end, pipe = os.pipe()
        os.close(end)
        command = [TOP, "--commands", self.commands, "--states", self.states, "--once", "--timeout", str(PATIENCE)]
        with os.fdopen(pipe, "w", encoding="utf-8") as output:
            done = subprocess.run(command, stdout=output, stderr=subprocess.PIPE, timeout=2 * PATIENCE, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, b""))

    def test_fields_of_another_kind_are_left_out(self):
        """By somebody in the server's place, who says every field of every message wrongly, and then rightly."""
        server = self.start()
        answer, said = self.client().ask("hello"), {}
        states = self.context.socket(zmq.SUB)
        states.connect(self.states)
        states.subscribe("")
        while {"stats", "force"} - said.keys():
            message = msgpack.unpackb(states.recv_multipart()[-1])
            said[message["type"]] = message
        states.close(linger=0)
        self.end(server)
        commands, states = self.context.socket(zmq.ROUTER), self.context.socket(zmq.PUB)
        states.setsockopt(zmq.SNDHWM, 0)
        commands.bind(self.commands)
        states.bind(self.states)
        top = self.start(program=TOP, arguments=["--commands", self.commands, "--states", self.states, "--once",
                                                 "--timeout", str(PATIENCE)],
                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + PATIENCE
        while top.poll() is None and time.monotonic() < deadline:
            while commands.poll(50):
                client, request = commands.recv_multipart()
                for reply in self.twisted_and_right(answer):
                    commands.send_multipart([client, msgpack.packb(reply | {"seq": msgpack.unpackb(request)["seq"]})])
            for message in said.values():
                for each in self.twisted_and_right(message):
                    states.send_multipart([message["type"].encode(), msgpack.packb(each)])
        self.assertEqual((top.wait(PATIENCE), top.stderr.read()), (0, ""))
        self.assertIn("scene 'small'", top.stdout.read())
        commands.close(linger=0)
        states.close(linger=0)

    @staticmethod
    def twisted_and_right(message):
        """The message with one field of another kind, or not there, for each; then the message."""
        for name in message.keys() - {"v", "type", "seq"}:
            for value in ("text", None, [], {}, [[]], -1.5, True, b"bytes", 1 << 63):
                if type(value) is not type(message[name]):
                    yield message | {name: value}
            yield {key: value for key, value in message.items() if key != name}
        yield message

    def test_no_server_and_bad_arguments_have_a_status(self):
        self.assertEqual(self.top("--once", "--timeout", "0.3").returncode, 3)
        self.assertEqual(self.top("--timeout", "never").returncode, 1)
        self.assertEqual(subprocess.run([TOP, "--commands", "nonsense"], stderr=subprocess.DEVNULL, check=False,
                                        timeout=PATIENCE).returncode, 1)


class WithKeys(WithServer):
    """A server that admits alice and not bob."""

    def setUp(self):
        super().setUp()
        for name in ("server", "alice", "bob"):
            made = self.start(program="acus-keygen", arguments=[self.path(name)], stdout=subprocess.DEVNULL)
            self.assertEqual(made.wait(PATIENCE), 0)

    def start_with_keys(self):
        self.start("--curve-server-key", self.path("server.key_secret"), "--curve-clients", self.path("alice.key"))

    def top(self, server, client, timeout=PATIENCE):
        command = [TOP, "--commands", self.commands, "--states", self.states, "--once", "--timeout", str(timeout)]
        keys = ["--curve-server-key", self.path(server), "--curve-client-key", self.path(client)]
        return subprocess.run(command + keys, capture_output=True, text=True, timeout=2 * PATIENCE, check=False)

    def test_a_server_with_keys_is_watched_by_whom_it_admits(self):
        self.start_with_keys()
        done = self.top("server.key", "alice.key_secret")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("scene 'small'\n", done.stdout)
        self.assertIn("of 200 Hz", done.stdout)

    def test_a_client_that_is_not_admitted_is_told_from_a_server_that_is_not_there(self):
        self.start_with_keys()
        refused = self.top("server.key", "bob.key_secret")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("refuses this client's key", refused.stderr)
        keyless = subprocess.run([TOP, "--commands", self.commands, "--states", self.states, "--once"],
                                 capture_output=True, text=True, timeout=2 * PATIENCE, check=False)
        self.assertEqual(keyless.returncode, 2)
        self.assertIn("admits only clients with keys", keyless.stderr)

    def test_keys_that_cannot_be_used_are_bad_arguments(self):
        with open(self.path("alice.key_secret"), encoding="utf-8") as file:
            alice = file.read()
        with open(self.path("bob.key"), encoding="utf-8") as file:
            bob = file.read()
        secret = re.search(r"secret-key = .*", alice)[0]
        self.write("open", alice)
        for name, text in (("mixed", bob + secret), ("short", bob + 'secret-key = "short"'), ("none", "")):
            os.chmod(self.write(name, text), 0o600)
        os.chmod(self.path("open"), 0o644)
        for server, client, bad, what in (("server.key_secret", "alice.key_secret", "server.key_secret", "secret key"),
                                          ("server.key", "alice.key", "alice.key", "no secret key"),
                                          ("server.key", "missing", "missing", "cannot be read"),
                                          ("none", "alice.key_secret", "none", "no public key"),
                                          ("server.key", "open", "open", "chmod 600"),
                                          ("server.key", "short", "short", "40 characters"),
                                          ("server.key", "mixed", "mixed", "not that of the secret key")):
            done = self.top(server, client)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn(f"'{self.path(bad)}'", done.stderr)
            self.assertIn(what, done.stderr)
            self.assertNotIn(secret.split('"')[1], done.stderr)
        alone = subprocess.run([TOP, "--curve-server-key", self.path("server.key")], capture_output=True, text=True,
                               timeout=PATIENCE, check=False)
        self.assertEqual(alone.returncode, 1)
        self.assertIn("give both or none", alone.stderr)


class Terminal(WithServer):
    """acus-top on a pseudo-terminal, whose screen pyte draws."""

    def setUp(self):
        super().setUp()
        self.file, terminal = pty.openpty()
        self.addCleanup(os.close, self.file)
        self.screen = pyte.Screen(100, 24)
        self.stream = pyte.ByteStream(self.screen)
        self.resize(24, 100)
        self.before = termios.tcgetattr(self.file)
        self.top = self.start(program=TOP, arguments=["--commands", self.commands, "--states", self.states],
                              stdin=terminal, stdout=terminal, stderr=terminal, start_new_session=True,
                              preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
                              env=dict(os.environ, TERM="vt100"))
        os.close(terminal)

    def resize(self, rows, columns):
        self.screen.resize(rows, columns)
        fcntl.ioctl(self.file, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def draw(self):
        """What comes within a tenth of a second."""
        if not select.select([self.file], [], [], 0.1)[0]:
            return
        try:
            self.stream.feed(os.read(self.file, 65536))
        except OSError:  # the other end is closed
            pass

    def wait_for(self, *texts):
        """Until the screen shows all of them at once."""
        deadline = time.monotonic() + PATIENCE
        while not all(text in "\n".join(self.screen.display) for text in texts):
            self.assertLess(time.monotonic(), deadline, "\n".join(self.screen.display))
            self.assertIsNone(self.top.poll(), "it ended")
            self.draw()

    def wait_for_end(self):
        deadline = time.monotonic() + PATIENCE
        while self.top.poll() is None:
            self.assertLess(time.monotonic(), deadline)
            self.draw()
        self.assertEqual(self.top.returncode, 0)

    def quit(self):
        os.write(self.file, b"q")
        self.wait_for_end()

    def test_it_survives_a_server_that_goes_and_comes_back(self):
        self.wait_for("no server has answered yet")
        server = self.start()
        self.wait_for("scene 'small'", "of 200 Hz", "left", "right")
        self.end(server)
        self.wait_for("scene 'small'", "NO WORD FOR")
        self.write("scene.yaml", SCENE.format(name="another"))
        self.start()
        self.wait_for("scene 'another'", "of 200 Hz")
        self.assertNotIn("NO WORD FOR", self.screen.display[0])
        self.quit()

    def test_it_survives_every_size_of_the_terminal(self):
        self.start()
        self.wait_for("of 200 Hz")
        for rows, columns in ((1, 1), (2, 3), (5, 20), (100, 300), (24, 100)):
            self.resize(rows, columns)
            self.top.send_signal(signal.SIGWINCH)
            for _ in range(5):
                self.draw()
            self.assertIsNone(self.top.poll())
        self.wait_for("of 200 Hz", "right")
        self.quit()

    def test_sigterm_leaves_the_terminal_as_it_was(self):
        self.wait_for("no server has answered yet")
        self.assertNotEqual(termios.tcgetattr(self.file), self.before)
        self.top.send_signal(signal.SIGTERM)
        self.wait_for_end()
        self.assertEqual(termios.tcgetattr(self.file), self.before)


if __name__ == "__main__":
    unittest.main()
