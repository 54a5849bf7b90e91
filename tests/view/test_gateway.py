#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Asks acus-view for what it serves and for what it must not, as other programs and other sites would."""

import base64
import glob
import http.client
import os
import select
import signal
import socket
import subprocess
import time
import unittest
from urllib.parse import urlsplit

from viewed import PATIENCE, WithGateway, scene


class Gateway(WithGateway):
    def test_a_cloud_is_of_worlds_or_of_an_endpoint(self):
        for cloud, what in (("1", "2 to 1000 worlds"), ("some", "endpoint 'some'")):
            process = self.launch("acus-view", "--no-browser", scene("insertion_pullback"), "--cloud", cloud)
            self.assertEqual(process.wait(PATIENCE), 1)
            self.assertIn(what, process.stderr.read())

    def test_a_cloud_that_is_started_ends_with_the_gateway(self):
        process, _ = self.view(scene("insertion_pullback"), "--lockstep", "--cloud", "2")
        line = process.stderr.readline()
        while line and "acus-cloud" not in line:
            line = process.stderr.readline()
        self.assertIn("acus-cloud: ", line)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(PATIENCE), 0)
        self.assertEqual(glob.glob(os.path.join(self.folder, "acus-view-*")), [])

    def ask(self, url, path, method="GET", **headers):
        connection = http.client.HTTPConnection("127.0.0.1", urlsplit(url).port, timeout=PATIENCE)
        self.addCleanup(connection.close)
        connection.request(method, path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read()

    def open_link(self, url, **headers):
        """A WebSocket's handshake by hand; the status, and the socket."""
        stream = socket.create_connection(("127.0.0.1", urlsplit(url).port), PATIENCE)
        self.addCleanup(stream.close)
        own = {"Host": urlsplit(url).netloc, "Origin": "http://" + urlsplit(url).netloc, "Upgrade": "websocket",
               "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
               "Sec-WebSocket-Key": base64.b64encode(os.urandom(16)).decode()}
        own.update({name.replace("_", "-"): value for name, value in headers.items()})
        lines = "".join(f"{name}: {value}\r\n" for name, value in own.items() if value)
        stream.sendall(f"GET /link HTTP/1.1\r\n{lines}\r\n".encode())
        head = b""
        while b"\r\n\r\n" not in head:
            more = stream.recv(4096)
            if not more:
                break
            head += more
        return int(head.split()[1]), stream

    def say(self, stream, text):
        """A masked text frame of up to 125 bytes."""
        data, mask = text.encode(), os.urandom(4)
        stream.sendall(bytes([0x81, 0x80 | len(data)]) + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(data)))

    def frame(self, stream):
        """Opcode and payload of the next frame; nothing where the connection ends."""
        def exactly(count):
            data = b""
            while len(data) < count:
                more = stream.recv(count - len(data))
                if not more:
                    raise EOFError
                data += more
            return data
        head = exactly(2)
        size = head[1] & 127
        if size > 125:
            size = int.from_bytes(exactly(2 if size == 126 else 8), "big")
        return head[0] & 15, exactly(size)

    def test_the_page_is_served_and_nothing_else(self):
        _, url = self.view("--commands", "ipc:///tmp/nobody", "--states", "ipc:///tmp/nobody-either")
        for path, kind in (("/", "text/html"), ("/index.html", "text/html"), ("/view.js", "text/javascript"),
                           ("/view.css", "text/css"), ("/NOTICE", "text/plain")):
            status, headers, body = self.ask(url, path)
            self.assertEqual(status, 200, path)
            self.assertTrue(headers["Content-Type"].startswith(kind), path)
            self.assertIn("default-src 'self'", headers["Content-Security-Policy"])
            self.assertGreater(len(body), 100)
        for path in ("/../../../etc/passwd", "/view.js/..", "/%2e%2e/NOTICE", "/favicon.ico", "//"):
            self.assertEqual(self.ask(url, path)[0], 404, path)
        self.assertIn(b"three.js", self.ask(url, "/NOTICE")[2])

    def test_other_sites_and_other_names_are_refused(self):
        _, url = self.view("--commands", "ipc:///tmp/nobody", "--states", "ipc:///tmp/nobody-either")
        port = urlsplit(url).port
        self.assertEqual(self.ask(url, "/", Host="evil.example")[0], 403)
        self.assertEqual(self.ask(url, "/", Host=f"evil.example:{port}")[0], 403)
        self.assertEqual(self.ask(url, "/", Host=f"localhost:{port}")[0], 200)
        for origin in ("http://evil.example", f"https://127.0.0.1:{port}", f"http://127.0.0.1:{port + 1}", "null", ""):
            self.assertEqual(self.open_link(url, Origin=origin)[0], 403, origin)
        self.assertEqual(self.open_link(url, Host="evil.example")[0], 403)
        self.assertEqual(self.open_link(url)[0], 101)

    def test_nothing_is_told_without_the_token(self):
        _, url = self.view(scene("insertion_pullback"))
        token = urlsplit(url).fragment
        self.assertEqual(len(token), 32)
        for wrong in ("", token[:-1], token + "0", "0" * 32):
            status, stream = self.open_link(url)
            self.assertEqual(status, 101)
            self.say(stream, '{"token": "%s"}' % wrong)
            opcode, payload = self.frame(stream)
            self.assertEqual((opcode, payload[:2]), (8, (1008).to_bytes(2, "big")))
        _, stream = self.open_link(url)
        self.say(stream, '{"drive": true}')
        self.assertEqual(self.frame(stream)[0], 8)
        _, stream = self.open_link(url)
        self.say(stream, '{"token": "%s"}' % token)
        (opcode, choices), (_, standing) = self.frame(stream), self.frame(stream)
        self.assertEqual(opcode, 1)
        self.assertIn(b'"insertion_pullback_layers"', choices)
        self.assertIn(b'"driving":false', standing)

    def test_recordings_are_handed_out_by_name_to_whoever_knows_the_token(self):
        _, url = self.view(scene("insertion_pullback"))
        folder = next(path for path in glob.glob(os.path.join(self.folder, "acus-view-*")))
        self.write(os.path.join(folder, "run.acus"), "a recording")
        token = {"Authorization": "Bearer " + urlsplit(url).fragment}
        connection = http.client.HTTPConnection("127.0.0.1", urlsplit(url).port, timeout=PATIENCE)
        self.addCleanup(connection.close)
        connection.request("HEAD", "/recordings/run.acus", headers=token)  # takes nothing home
        self.assertEqual(connection.getresponse().status, 405)
        self.assertEqual(self.ask(url, "/recordings/run.acus", **token)[::2], (200, b"a recording"))
        for credentials in ({}, {"Authorization": "Bearer "}, {"Authorization": "Bearer 0"}):
            self.assertEqual(self.ask(url, "/recordings/run.acus", **credentials)[0], 401)
        for name in ("", "other.acus", "../run.acus", ".", "..", "%2e%2e/run.acus", "a/b", "run.acus/"):
            self.assertEqual(self.ask(url, "/recordings/" + name, **token)[0], 404, name)

    def test_a_recording_stays_until_somebody_says_that_it_is_saved(self):
        _, url = self.view(scene("insertion_pullback"))
        folder = next(path for path in glob.glob(os.path.join(self.folder, "acus-view-*")))
        kept = self.write(os.path.join(folder, "run.acus"), 1000 * "a recording")
        token = {"Authorization": "Bearer " + urlsplit(url).fragment}
        unread = http.client.HTTPConnection("127.0.0.1", urlsplit(url).port, timeout=PATIENCE)
        unread.request("GET", "/recordings/run.acus", headers=token)
        unread.sock.recv(1, socket.MSG_PEEK)  # the answer is there
        unread.close()
        for _ in range(2):
            self.assertEqual(len(self.ask(url, "/recordings/run.acus", **token)[2]), 11_000)
        for credentials in ({}, {"Authorization": "Bearer 0"}, {**token, "Host": "evil.example"}):
            self.assertIn(self.ask(url, "/recordings/run.acus", "DELETE", **credentials)[0], (401, 403))
        self.assertEqual(self.ask(url, "/recordings/../run.acus", "DELETE", **token)[0], 404)
        self.assertTrue(os.path.exists(kept))
        for status in (200, 404):
            self.assertEqual(self.ask(url, "/recordings/run.acus", "DELETE", **token)[0], status)
        self.assertFalse(os.path.exists(kept))

    def test_the_token_stands_on_no_command_line(self):
        os.mkfifo(self.path("told"))
        self.write("xdg-open", '#!/bin/sh\n{ echo "$@"; stat -c %a "$1"; cat "$1"; } > "$(dirname "$0")/told"\n')
        os.chmod(self.path("xdg-open"), 0o755)
        process = self.start(program="acus-view", arguments=[scene("insertion_pullback")], stdout=subprocess.PIPE, text=True, stderr=subprocess.PIPE,
                             env=dict(os.environ, TMPDIR=self.folder, DISPLAY=":9", PATH=f"{self.folder}:{os.environ['PATH']}"))
        with open(self.path("told"), encoding="utf-8") as file:
            arguments, mode, *page = file.read().splitlines()
        url = process.stdout.readline().strip()
        self.assertNotIn(urlsplit(url).fragment, arguments)
        self.assertEqual((mode, os.path.exists(arguments)), ("600", True))
        self.assertIn(f'content="0; url={url}"', "".join(page))
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(PATIENCE), 0)
        self.assertFalse(os.path.exists(arguments))

    def test_a_recording_that_nobody_saved_is_kept(self):
        process, _ = self.view(scene("insertion_pullback"))
        folder = next(path for path in glob.glob(os.path.join(self.folder, "acus-view-*")))
        self.write(os.path.join(folder, "run.acus"), "a recording")
        process.terminate()
        _, words = process.communicate(timeout=PATIENCE)
        self.assertIn("recordings that nobody saved are in " + folder, words)
        self.assertTrue(os.path.exists(os.path.join(folder, "run.acus")))

    def test_a_page_that_takes_nothing_in_is_not_flooded(self):
        _, url = self.view(scene("insertion_pullback"))
        _, stream = self.open_link(url)
        self.say(stream, '{"token": "%s"}' % urlsplit(url).fragment)
        beats = []
        while len(beats) < 3:
            opcode, payload = self.frame(stream)
            if opcode == 1 and payload.startswith(b'{"beat"'):
                beats.append(payload.decode())
        self.assertEqual(beats, ['{"beat":1}', '{"beat":2}', '{"beat":3}'])
        stream.settimeout(0.5)
        self.assertRaises(TimeoutError, self.frame, stream)
        stream.settimeout(PATIENCE)
        self.say(stream, beats[1])
        while not (opcode == 1 and payload == b'{"beat":5}'):
            opcode, payload = self.frame(stream)

    def test_there_is_room_for_so_many_and_no_more(self):
        _, url = self.view("--commands", "ipc:///tmp/nobody", "--states", "ipc:///tmp/nobody-either")
        token = urlsplit(url).fragment
        streams = []
        for _ in range(64):
            streams.append(self.open_link(url)[1])
            self.say(streams[-1], '{"token": "%s"}' % token)
            self.assertEqual(self.frame(streams[-1])[0], 1)
        _, stream = self.open_link(url)
        self.say(stream, '{"token": "%s"}' % token)
        self.assertEqual(self.frame(stream)[0], 8)

    def test_it_ends_in_order_and_takes_its_server_along(self):
        for _ in range(10):  # also a server that has only just been started
            process, _ = self.view(scene("insertion_pullback"))
            children = f"/proc/{process.pid}/task/{process.pid}/children"
            with open(children, encoding="utf-8") as file:
                server = int(file.read().split()[0])
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.wait(PATIENCE), 0, process.stderr.read())
            self.assertFalse(os.path.exists(f"/proc/{server}"))

    def test_a_server_that_hangs_does_not_keep_it(self):
        process, _ = self.view(scene("insertion_pullback"))
        with open(f"/proc/{process.pid}/task/{process.pid}/children", encoding="utf-8") as file:
            server = int(file.read().split()[0])
        os.kill(server, signal.SIGSTOP)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(PATIENCE), 0)
        self.assertFalse(os.path.exists(f"/proc/{server}"))

    def test_connections_that_ask_for_nothing_leave_room_when_they_end(self):
        _, url = self.view("--commands", "ipc:///tmp/nobody", "--states", "ipc:///tmp/nobody-either")
        idle = [socket.create_connection(("127.0.0.1", urlsplit(url).port), PATIENCE) for _ in range(300)]
        for stream in idle:
            stream.close()
        self.assertEqual(self.ask(url, "/")[0], 200)

    def test_idle_connections_keep_nobody_out(self):
        _, url = self.view("--commands", "ipc:///tmp/nobody", "--states", "ipc:///tmp/nobody-either")
        idle = [socket.create_connection(("127.0.0.1", urlsplit(url).port), PATIENCE) for _ in range(200)]
        idle += [self.open_link(url)[1] for _ in range(100)]  # without a token
        for _ in range(3):
            self.assertEqual(self.ask(url, "/")[0], 200)
        ended, _, _ = select.select(idle, [], [], 0)
        self.assertLess(len(ended), 60)  # 44 and those for the requests; all of them after 10 s
        for stream in idle:
            stream.close()

    def test_a_server_that_ends_with_its_gateway_killed(self):
        process, _ = self.view(scene("insertion_pullback"))
        with open(f"/proc/{process.pid}/task/{process.pid}/children", encoding="utf-8") as file:
            server = int(file.read().split()[0])
        process.kill()
        deadline = time.monotonic() + PATIENCE
        while os.path.exists(f"/proc/{server}") and time.monotonic() < deadline:
            with open(f"/proc/{server}/stat", encoding="utf-8") as file:
                if file.read().split()[2] == "Z":
                    break
            time.sleep(0.05)
        self.assertLess(time.monotonic(), deadline)

    def test_a_recording_that_cannot_be_used_is_named(self):
        run = self.path("run.acus")
        with open(run, "wb") as file:
            file.write(b"\x28\xb5\x2f\xfd and nothing that zstd knows")
        process = self.launch("acus-view", "--no-browser", run)
        _, words = process.communicate(timeout=PATIENCE)
        self.assertEqual(process.returncode, 2)
        self.assertIn("run.acus", words)

    def test_what_cannot_be_used_is_named(self):
        recording = self.path("run.acus")
        with open(recording, "wb") as file:
            file.write(b"\x28\xb5\x2f\xfd")
        for arguments, status, words in (
            (["no_such_scene.yaml"], 1, "no_such_scene.yaml: expected the file of a scene or a recording"),
            ([self.write("bad.yaml", "needles: none")], 2, "the server has ended with status 2"),
            ([recording, "--play"], 1, "--play, --lockstep and --cloud are for scenes"),
            (["--page", "/nowhere", scene("insertion_pullback")], 3, "/nowhere/index.html: expected a file of the page"),
            (["--commands", "nonsense"], 1, "--commands"),
            ([scene("insertion_pullback"), "--commands", "tcp://127.0.0.1:5750"], 1, "excludes"),
        ):
            process = self.launch("acus-view", "--no-browser", *arguments)
            self.assertEqual(process.wait(PATIENCE), status, words)
            self.assertIn(words, process.stderr.read())
        _, url = self.view(scene("insertion_pullback"))
        process = self.launch("acus-view", "--no-browser", "--port", str(urlsplit(url).port))
        self.assertEqual(process.wait(PATIENCE), 3)
        self.assertIn("port", process.stderr.read())


class SlowDownload(WithGateway):
    def test_a_download_that_takes_long_is_not_cut(self):
        _, url = self.view(scene("insertion_pullback"))
        folder = next(path for path in glob.glob(os.path.join(self.folder, "acus-view-*")))
        self.write(os.path.join(folder, "run.acus"), "x" * 20_000_000)
        connection = http.client.HTTPConnection("127.0.0.1", urlsplit(url).port, timeout=PATIENCE)
        self.addCleanup(connection.close)
        connection.request("GET", "/recordings/run.acus", headers={"Authorization": "Bearer " + urlsplit(url).fragment})
        answer = connection.getresponse()
        read = len(answer.read(1000))
        time.sleep(15)  # longer than for a request
        self.assertEqual(read + len(answer.read()), 20_000_000)


if __name__ == "__main__":
    unittest.main()
