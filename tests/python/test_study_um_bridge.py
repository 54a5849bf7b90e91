#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A study as a model of UM-Bridge: a client of our own sees what protocol 1.0 asks for, and outputs are those of the study."""

import http.client
import json
import math
import os
import signal
import socket
import subprocess
import threading
import time
import unittest
from concurrent.futures import ThreadPoolExecutor

from of_studies import PUSH, STIFFNESS, OfStudies
from small_scene import PATIENCE, ROOT, SCENE

import acus  # noqa: E402
from acus.study.um_bridge import MOST_WAITING  # noqa: E402


class Client:
    """Of one server."""

    def __init__(self, port):
        self.port = port

    def ask(self, path, request=None, method=None, body=None, headers=None):
        """Status and answer."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        body = json.dumps(request).encode() if request is not None else body
        connection.request(method or ("GET" if body is None else "POST"), path, body, headers or {})
        answer = connection.getresponse()
        text = answer.read()
        connection.close()
        return answer.status, json.loads(text) if text else None

    def evaluate(self, values):
        return self.ask("/Evaluate", {"name": "forward", "input": [values], "config": {}})


def gives_up(result):
    if result.parameters[STIFFNESS] > 1e5:
        os.kill(os.getpid(), signal.SIGKILL)
    return math.nan if result.parameters[STIFFNESS] > 5e4 else 1.0


class Model(OfStudies):
    def setUp(self):
        super().setUp()
        self.made = self.study({STIFFNESS: [5e3, 10e3], "motion.tilt": [0.1]}, outputs={"force": "peak_force", "tip": "tip", "fine": gives_up})
        server = self.made.model_server(0, workers=2)
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        self.client = Client(server.server_port)
        self.addCleanup(server.server_close)
        self.addCleanup(thread.join)
        self.addCleanup(server.shutdown)

    def test_it_is_what_the_protocol_asks_for(self):
        model = {"name": "forward"}
        self.assertEqual(self.client.ask("/Info"), (200, {"protocolVersion": 1.0, "models": ["forward"]}))
        self.assertEqual(self.client.ask("/", method="HEAD"), (200, None))
        self.assertEqual(self.client.ask("/ModelInfo", model), (200, {"support": {
            "Evaluate": True, "Gradient": False, "ApplyJacobian": False, "ApplyHessian": False}}))
        self.assertEqual(self.client.ask("/InputSizes", model), (200, {"inputSizes": [2]}))
        self.assertEqual(self.client.ask("/OutputSizes", model), (200, {"outputSizes": [5]}))
        for path, request, kind in (("/Evaluate", {"name": "other"}, "ModelNotFound"), ("/InputSizes", {}, "ModelNotFound"),
                                    ("/Gradient", model, "UnsupportedFeature"), ("/ApplyHessian", model, "UnsupportedFeature"),
                                    ("/Evaluate", {**model, "input": [[1.0]]}, "InvalidInput"), ("/Evaluate", model, "InvalidInput"),
                                    ("/Evaluate", {**model, "input": [[1.0, 2.0, 3.0]]}, "InvalidInput"),
                                    ("/Evaluate", {**model, "input": [[1.0, "x"]]}, "InvalidInput"),
                                    ("/Evaluate", {**model, "input": [[math.nan, 1.0]]}, "InvalidInput"),
                                    ("/Evaluate", [], "InvalidInput")):
            status, answer = self.client.ask(path, request)
            with self.subTest(path=path, request=str(request)):
                self.assertEqual((status, answer["error"]["type"]), (400, kind), answer)
        for body in (b"{", b"\xff", b"", b"[" * 500_000, b'{"name": "forward", "input": [[1' + 400 * b"0" + b", 1]]}"):
            self.assertEqual(self.client.ask("/Evaluate", body=body)[0], 400)
        self.assertEqual(self.client.ask("/nothing", {})[0], 404)
        self.assertEqual(self.client.ask("/Evaluate", body=b" " * (2 << 20))[0], 413)

    def test_what_a_browser_sends_unasked_is_refused(self):
        body = json.dumps({"name": "forward", "input": [[5e3, 0.1]]}).encode()
        own, kind = f"127.0.0.1:{self.client.port}", {"Content-Type": "application/json"}
        for status, headers in ((200, kind), (200, {}), (200, {"Content-Type": "application/json; charset=utf-8"}), (200, {"Host": "localhost"}),
                                (200, {"Host": f"[::1]:{self.client.port}"}), (200, {"Host": own, "Origin": "http://" + own}),
                                (403, {**kind, "Origin": "http://evil.example"}), (403, {**kind, "Origin": "null"}),
                                (403, {**kind, "Origin": "https://" + own}), (403, {**kind, "Host": "evil.example"}), (403, {"Host": ""}),
                                (403, {"Host": f"evil.example:{self.client.port}"}), (403, {"Host": "127.0.0.1.evil.example"}),
                                (403, {"Host": "evil.example", "Origin": "http://evil.example"}), (415, {"Content-Type": "text/plain"}),
                                (415, {"Content-Type": "application/x-www-form-urlencoded"}), (415, {"Content-Type": "multipart/form-data"}),
                                (415, {"Content-Type": ""})):
            with self.subTest(headers=headers):
                self.assertEqual(self.client.ask("/Evaluate", body=body, headers=headers)[0], status)
        for headers in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}):
            self.assertEqual(self.client.ask("/Info", headers=headers)[0], 403)

    def test_connections_that_wait_keep_nobody_out(self):
        slow = [socket.create_connection(("127.0.0.1", self.client.port), PATIENCE) for _ in range(MOST_WAITING + 20)]
        for connection in slow:
            self.addCleanup(connection.close)
            connection.sendall(b"POST /Evaluate HTTP/1.1\r\nHost: ")
        kept = http.client.HTTPConnection("127.0.0.1", self.client.port, timeout=PATIENCE)
        self.addCleanup(kept.close)
        for _ in range(3):
            self.assertEqual(self.client.evaluate([5e3, 0.1])[0], 200)
            kept.request("GET", "/Info")
            self.assertEqual(json.loads(kept.getresponse().read())["models"], ["forward"])
        self.assertEqual(slow[0].recv(1), b"")  # the one that has waited longest was ended

    def test_outputs_are_those_of_the_study(self):
        rows = self.made.run(workers=0, progress=False).rows
        with ThreadPoolExecutor(4) as pool:
            answers = list(pool.map(self.client.evaluate, [[row[STIFFNESS], row["motion.tilt"]] for row in rows] * 3))
        for row, (status, answer) in zip(rows * 3, answers):
            self.assertEqual((status, answer), (200, {"output": [[row["force"], row["tip.x"], row["tip.y"], row["tip.z"], 1.0]]}))

    def test_a_connection_that_is_closed_takes_no_worker_with_it(self):
        for _ in range(2):
            self.assertEqual(self.client.evaluate([2e5, 0.0])[0], 500)  # whose workers are replaced
            time.sleep(1)
            self.assertEqual([self.client.evaluate([5e3, 0.1])[0] for _ in range(2)], [200, 200])

    def test_it_ends_with_cases_under_way(self):
        def endless(world):
            while True:
                world.step() if world.parameters["way"] else time.sleep(PATIENCE)

        def begins(world):
            if world.parameters["way"] > 0:
                endless(world)
            world.step()

        server = self.study({"way": [0]}, motion=begins, outputs={"n": lambda result: 1}).model_server(0, workers=2)
        serving = threading.Thread(target=server.serve_forever)
        serving.start()
        with ThreadPoolExecutor(2) as pool:
            answers = [pool.submit(Client(server.server_port).evaluate, [1.0]) for _ in range(2)]
            time.sleep(1)
            server.shutdown()
            server.server_close()
            self.assertEqual([answer.result()[0] for answer in answers], [500, 500])
        serving.join()
        self.assertTrue(all(worker._process.poll() is not None for worker in server.model._workers))  # pylint: disable=protected-access

    def test_cases_that_fail_are_told_and_the_next_ones_run(self):
        for values, what in (([-1.0, 0.0], "SceneError"), ([6e4, 0.0], "fine is nan"), ([2e5, 0.0], "process died")):
            status, answer = self.client.evaluate(values)
            self.assertEqual((status, answer["error"]["type"]), (500, "InvalidOutput"))
            self.assertIn(what, answer["error"]["message"])
        self.assertEqual(self.client.evaluate([5e3, 0.1])[0], 200)


class Starting(OfStudies):
    def test_studies_that_are_no_models(self):
        for settings, what in (({"parameters": {"motion.entry": [(0, 0, 0.05)]}}, "have to be numbers"),
                               ({"outputs": {"text": lambda result: "a"}}, "outputs have to be numbers"),
                               ({"parameters": {STIFFNESS: [-1.0]}}, "first case failed: SceneError")):
            self.assertRaisesRegex(acus.StudyError, what, self.study(**settings).model_server, 0, workers=1)
        with self.study(motion=PUSH).model_server(0, workers=1) as server:
            self.assertRaisesRegex(acus.StudyError, "in use", self.study().model_server, server.server_port, workers=1)

    def test_the_program(self):
        self.write("small.yaml", SCENE.format(name="small"))
        self.write("model.py", "import acus\ndef twice(result):\n    return 2 * result.parameters['motion.depth']\n"
                   "study = acus.Study('./small.yaml', acus.Insertion(depth=0.01, speed=0.1), {'motion.depth': [0.01]}, [twice])\n")
        program = os.path.join(ROOT, "client", "study")
        server = subprocess.Popen([program, "serve", "model.py", "--port", "0", "--workers", "1"], stdout=subprocess.PIPE, text=True,
                                  cwd=self.folder)
        line = server.stdout.readline()
        self.assertIn("model 'forward': motion.depth -> twice", line)
        self.assertEqual(Client(int(line.split(",")[0].rpartition(":")[2])).evaluate([0.02]), (200, {"output": [[0.04]]}))
        server.terminate()
        server.stdout.close()
        self.assertEqual(server.wait(PATIENCE), 0)
        self.write("none.py", "study = 5\n")
        for file, what in (("none.py", "sets `study`"), ("nowhere.py", "No such file")):
            done = subprocess.run([program, "serve", file], cwd=self.folder, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 1)
            self.assertIn(what, done.stderr)


if __name__ == "__main__":
    unittest.main()
