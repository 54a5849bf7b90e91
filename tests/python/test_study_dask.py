#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies on a Dask cluster on this machine whose workers are killed all the time: no case is lost, none is there twice."""

import importlib.util
import os
import random
import shutil
import socket
import subprocess
import threading
import unittest

from of_studies import PUSH, STIFFNESS, OfStudies
from small_scene import ROOT

import acus  # noqa: E402
from acus import study  # noqa: E402

KILLING = 4.0  # s between two
CASES = 500


@unittest.skipUnless(importlib.util.find_spec("distributed") and shutil.which("dask-worker"),
                     "SKIPPED: Dask is missing (python3-distributed)")
class OnDask(OfStudies):
    def setUp(self):
        super().setUp()
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"127.0.0.1:{free.getsockname()[1]}"
        self.processes = [self.start("dask-scheduler", "--host", "127.0.0.1", "--port", self.address.partition(":")[2])]
        self.addCleanup(self.end)

    def start(self, *command):
        path = os.pathsep.join([os.path.join(ROOT, "client", "python"), os.path.join(ROOT, "tests", "python")])
        with open(self.path("dask.log"), "ab") as log:
            return subprocess.Popen([*command, "--no-dashboard"], env={**os.environ, "PYTHONPATH": path}, stdout=log, stderr=log,
                                    cwd=self.folder)

    def start_worker(self):
        return self.start("dask-worker", "tcp://" + self.address, "--nthreads", "1", "--no-nanny")

    def end(self):
        for process in self.processes:
            process.kill()
            process.wait()

    def run_on(self, made, **settings):
        return made.run(on="dask://" + self.address, progress=False, **settings)

    def test_workers_that_are_killed_lose_no_case(self):
        cases = study.latin_hypercube({STIFFNESS: (5e3, 2e4), "motion.tilt": (0.0, 0.1)}, CASES)
        slow = acus.Insertion(depth=0.03, speed=0.005)
        self.processes += [self.start_worker() for _ in range(3)]
        over, kills = threading.Event(), []

        def kill():
            while not over.wait(KILLING):
                victim = random.randrange(1, len(self.processes))
                self.processes[victim].kill()
                self.processes[victim].wait()
                kills.append(victim)
                self.processes[victim] = self.start_worker()

        killer = threading.Thread(target=kill)
        killer.start()
        try:
            made = self.run_on(self.study(cases, motion=slow, folder="dask"))
        finally:
            over.set()
            killer.join()
        self.assertGreater(len(kills), 3)
        self.assertEqual([row["case"] for row in made.rows], list(range(CASES)))
        self.assertEqual([row["error"] for row in made.rows], [""] * CASES)
        with open(self.path("dask", "rows.jsonl"), encoding="utf-8") as file:
            self.assertEqual(len(file.readlines()), CASES)
        serial = self.study(cases, motion=slow, folder="serial").run(progress=False, workers=2)
        self.assertEqual(made.digest, serial.digest)

    def test_a_case_that_fails_or_crashes_is_told_and_recorded(self):
        def motion(world):
            world.step(5)
            if world.parameters["way"] == "crash":
                os.kill(os.getpid(), 9)
            if world.parameters["way"] == "fail":
                raise ValueError("cannot go on")

        self.processes.append(self.start_worker())
        made = self.run_on(self.study({"way": ["go", "fail", "crash", "go"]}, motion=motion, outputs=["depth"]))
        self.assertEqual([row["error"][:24] for row in made.rows], ["", "ValueError: cannot go on", "the process died: of a c", ""])
        self.assertGreater(os.path.getsize(made.recording(1)), 100)
        self.assertIsNone(made.recording(0))

    def test_what_workers_cannot_run_is_told(self):
        self.processes.append(self.start("dask-worker", "tcp://" + self.address, "--nthreads", "2", "--no-nanny"))
        made = self.study({STIFFNESS: [5e3] * 8}, motion=PUSH)
        self.assertEqual(len(self.run_on(made).rows), 8)
        self.processes.pop().kill()
        with open(self.path("dask.log"), "ab") as log:  # one that does not find acus
            self.processes.append(subprocess.Popen(["dask-worker", "tcp://" + self.address, "--no-nanny", "--no-dashboard"],
                                                   env={**os.environ, "PYTHONPATH": ""}, stdout=log, stderr=log, cwd=self.folder))
        self.assertRaisesRegex(acus.StudyError, "can it import acus", self.run_on, self.study({STIFFNESS: [6e3]}))


@unittest.skipUnless(importlib.util.find_spec("distributed"), "SKIPPED: Dask is missing (python3-distributed)")
class Nobody(OfStudies):
    def test_a_scheduler_that_is_not_there(self):
        self.assertRaisesRegex(acus.StudyError, "no Dask scheduler answers", self.study().run, on="dask://127.0.0.1:1", progress=False)

    def test_addresses_that_are_none(self):
        for settings in ({"on": "slurm://x"}, {"on": 5}, {"on": "dask://127.0.0.1:1", "workers": 2}):
            self.assertRaisesRegex(acus.StudyError, "expected dask://HOST:PORT", self.study().run, progress=False, **settings)


if __name__ == "__main__":
    unittest.main()
