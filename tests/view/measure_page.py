#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the page of acus-view in headless Chromium, which draws in software, and what viewers cost the server.
Usage: ACUS_PROGRAMS=build/release/bin tests/view/measure_page.py [MINUTES]
Prints the figures of docs/viewer.md. MINUTES (default 10) is how long memory is watched."""

import base64
import json
import os
import socket
import statistics
import subprocess
import sys
import threading
import time
from urllib.parse import urlsplit

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "client", "python"))

import acus  # noqa: E402
import test_page  # noqa: E402
from viewed import scene  # noqa: E402

MINUTES = float(sys.argv.pop()) if len(sys.argv) > 1 else 10.0

# Counts pictures and, for each, how long ago the newest of its states' commands left the page.
WATCH = """
window.delays = []; window.begun = performance.now(); window.first = acus.frames;
const look = () => {
  const force = acus.force('needle');
  if (force && force.echo > 0 && force.echo !== window.echo) {
    window.echo = force.echo;
    window.delays.push(performance.now() - 1000 * force.echo);
  }
  requestAnimationFrame(look);
};
requestAnimationFrame(look);
"""


def resident(pid):
    with open(f"/proc/{pid}/status", encoding="utf-8") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS")) / 1024


class Looker(threading.Thread):
    """A viewer without a browser: it reads what comes."""

    def __init__(self, url):
        super().__init__(daemon=True)
        parts = urlsplit(url)
        self.stream = socket.create_connection(("127.0.0.1", parts.port))
        key = base64.b64encode(os.urandom(16)).decode()
        self.stream.sendall((f"GET /link HTTP/1.1\r\nHost: {parts.netloc}\r\nOrigin: http://{parts.netloc}\r\n"
                             "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                             f"Sec-WebSocket-Key: {key}\r\n\r\n").encode())
        self.stream.recv(4096)
        self.bytes = 0
        self.say(json.dumps({"token": parts.fragment}).encode())
        self.start()

    def exactly(self, count):
        data = b""
        while len(data) < count:
            more = self.stream.recv(count - len(data))
            if not more:
                raise EOFError
            data += more
        self.bytes += count
        return data

    def say(self, data):
        self.stream.sendall(bytes([0x81, 0x80 | len(data), 0, 0, 0, 0]) + data)

    def run(self):
        while True:
            try:
                head = self.exactly(2)
                size = head[1] & 127
                if size > 125:
                    size = int.from_bytes(self.exactly(2 if size == 126 else 8), "big")
                data = self.exactly(size)
                if data.startswith(b'{"beat"'):
                    self.say(data)
            except (EOFError, OSError):
                return


class Measure(test_page.Page):
    def late(self, endpoints, seconds):
        """Late ticks in a thousand, from what the server tells."""
        with acus.Client(*endpoints) as client:
            ticks = late = 0
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                client.wait()
                if client.stats is not None and client.stats is not getattr(self, "seen", None):
                    self.seen = client.stats
                    ticks += client.stats.ticks
                    late += client.stats.late
            return 1000 * late / max(ticks, 1)

    def test_page(self):
        process, url = self.view(scene("benchmark/cube_3375"))
        begun = time.monotonic()
        self.look(url)
        self.wait_for("window.acus && acus.frames > 0 && acus.force('needle')")
        drawn = time.monotonic() - begun
        self.wait_for("performance.getEntriesByName('first-contentful-paint').length > 0")
        paint = self.get("performance.getEntriesByName('first-contentful-paint')[0].startTime")
        print(f"page visible {paint / 1000:.2f} s after it was asked for, tissue and needle drawn after {drawn:.2f} s")
        self.take()
        self.browser.execute_script(WATCH)
        self.browser.execute_script("acus.hands.keys.add('w')")
        time.sleep(10)
        delays, frames = self.get("[window.delays, (acus.frames - window.first) / (performance.now() - window.begun) * 1000]")
        delays.sort()
        print(f"3,375 nodes: {frames:.1f} pictures a second ({self.get('acus.renderer()')}); from hand to picture "
              f"p50 {delays[len(delays) // 2]:.0f} ms, p95 {delays[int(0.95 * len(delays))]:.0f} ms")
        self.browser.execute_script("acus.hands.keys.delete('w')")
        before = None
        for minute in range(int(MINUTES) + 1):
            heap = self.browser.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"] / 2**20
            now = (resident(process.pid), heap)
            before = before or now
            print(f"after {minute} min: gateway {now[0]:.1f} MiB, page's heap {now[1]:.1f} MiB", flush=True)
            if minute < int(MINUTES):
                time.sleep(60)

    def test_server(self):
        endpoints = [self.commands, self.states]
        self.serve(scene("benchmark/cube_1000"))
        shares = {0: [], 20: []}
        for turn in range(3):
            shares[0].append(self.late(endpoints, 20))
            process, url = self.view("--commands", endpoints[0], "--states", endpoints[1])
            lookers = [Looker(url) for _ in range(20)]
            shares[20].append(self.late(endpoints, 20))
            amount = sum(each.bytes for each in lookers) / 20 / 20 / 1e6
            self.end(process)
        for viewers, late in shares.items():
            print(f"with {viewers} viewers: late {', '.join(f'{each:.2f}' for each in late)} of 1,000 ticks")
        print(f"each viewer got {amount:.2f} MB a second")


if __name__ == "__main__":
    test_page.unittest.main()
