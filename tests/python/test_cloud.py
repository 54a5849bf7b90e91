#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.plan.Cloud and acus-cloud: worlds of what may be true, beside one that runs. Servers run in lockstep: nothing waits for
time."""

import os
import re
import subprocess
import sys
import threading
import time
import unittest

import msgpack
import numpy as np
import zmq

from small_scene import PATIENCE, ROOT, InTemporaryFolder

import acus  # noqa: E402
from acus import engine  # noqa: E402
from acus.env.scenes import steering  # noqa: E402
from acus.plan.cloud import spread_of  # noqa: E402

PROGRAM = [sys.executable, os.path.join(ROOT, "client", "cloud")]
SPEED = 0.08  # m/s


def small():
    scene = steering()
    scene["tissue.mesh.box.cells"] = [4, 4, 6]
    return scene


def commands(needle, seconds):
    return {needle.name: (needle.base_position + SPEED * seconds * needle.axis, needle.base_orientation, 0.0)}


@unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
class Worlds(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = small()
        cls.model = engine.load(cls.scene)
        cls.needle = cls.model.needles[0]

    def followed(self, cloud, seconds, state):
        stride = round(cloud.time_step / self.model.time_step)
        while state.time < seconds:
            engine.step(self.model, state, commands(self.needle, state.time + cloud.time_step), ticks=stride)
            cloud.step(commands(self.needle, state.time))
        return cloud.tips(self.needle.name), np.array(state.needle_positions(self.needle.name)[-1])

    def test_tips_part_as_the_needle_goes_in_and_the_unchanged_world_stays_with_it(self):
        cloud, state = acus.plan.Cloud(self.scene, worlds=5, rate=self.model.rate / 4), self.model.start()
        cloud.begin(state)
        outside, tip = self.followed(cloud, 0.08, state)
        self.assertLess(spread_of(outside), 1e-6)
        spreads = []
        for seconds in (0.6, 1.0, 1.4):
            tips, tip = self.followed(cloud, seconds, state)
            self.assertLess(np.linalg.norm(tips[0] - tip), SPEED * cloud.time_step)
            spreads.append(spread_of(tips))
        self.assertEqual(spreads, sorted(spreads))
        self.assertGreater(spreads[-1], 2e-4)
        self.assertEqual(cloud.draws[0], {})
        self.assertAlmostEqual(cloud.time, state.time)

    def test_a_larger_uncertainty_spreads_more(self):
        spreads = []
        for factor in (1.1, 1.5):
            cloud, state = acus.plan.Cloud(self.scene, {"bevel": (2 - factor, factor)}, worlds=4, rate=self.model.rate / 4), self.model.start()
            cloud.begin(state)
            spreads.append(spread_of(self.followed(cloud, 1.2, state)[0]))
        self.assertGreater(spreads[1], 3 * spreads[0])

    def test_it_branches_from_any_state(self):
        state = self.model.start()
        for _ in range(round(1.0 * self.model.rate)):
            engine.step(self.model, state, commands(self.needle, state.time + self.model.time_step))
        cloud = acus.plan.Cloud(self.scene, worlds=4, rate=self.model.rate / 4)
        cloud.begin(state)
        np.testing.assert_array_equal(cloud.tips(self.needle.name), 4 * [state.needle_positions(self.needle.name)[-1]])
        self.assertGreater(spread_of(self.followed(cloud, 1.4, state)[0]), 2e-5)

    def test_worlds_that_are_left_out_are_there_again_at_the_next_beginning(self):
        cloud, state = acus.plan.Cloud(self.scene, worlds=3), self.model.start()
        cloud.begin(state)
        cloud.leave_out()
        self.assertEqual((len(cloud), cloud.tips(self.needle.name).shape), (2, (2, 3)))
        cloud.begin(state)
        self.assertEqual(len(cloud), 3)

    def test_the_same_seed_draws_the_same(self):
        clouds = [acus.plan.Cloud(self.scene, worlds=3, seed=seed) for seed in (1, 1, 2)]
        self.assertEqual(clouds[0].draws, clouds[1].draws)
        self.assertNotEqual(clouds[0].draws, clouds[2].draws)

    def test_errors_name_the_argument(self):
        for settings, what in (({"worlds": 1}, "worlds: expected a whole number, at least 2"), ({"rate": 0}, "rate: expected a number above 0"),
                               ({"uncertain": {}}, "uncertain: expected something"), ({"uncertain": {"stifness": (1, 2)}}, "uncertain: expected stiffness")):
            self.assertRaisesRegex(acus.PlanError, what, acus.plan.Cloud, self.scene, **settings)


@unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
class Program(InTemporaryFolder):
    def setUp(self):
        super().setUp()
        self.scene = self.path("small.yaml")
        small().save(self.scene)
        self.server = acus.Server(self.scene, lockstep=True)
        self.addCleanup(self.server.end)
        self.client = self.server.client()
        self.addCleanup(self.client.close)
        self.needle = self.client.needles[0]
        self.client.acquire(self.needle)
        self.context = zmq.Context()
        self.addCleanup(self.context.destroy)
        self.socket = self.context.socket(zmq.SUB)
        self.socket.connect("ipc://" + self.path("cloud"))
        self.socket.subscribe("cloud")

    def follow(self, *arguments):
        program = subprocess.Popen([*PROGRAM, "--publish", "ipc://" + self.path("cloud"), "--commands", self.server.commands,
                                    "--states", self.server.states, *arguments], stderr=subprocess.PIPE, text=True)
        watch = threading.Timer(PATIENCE, program.kill)  # so that no line is waited for in vain
        watch.start()
        self.addCleanup(watch.cancel)
        self.addCleanup(program.stderr.close)
        self.addCleanup(program.wait, PATIENCE)
        self.addCleanup(program.terminate)
        return program

    def told(self, program, what):
        """Reads its lines until one matches."""
        lines = []
        while not lines or not re.search(what, lines[-1]):
            lines.append(program.stderr.readline())
            self.assertTrue(lines[-1], lines)

    def go(self, seconds):
        """Forwards, so long; the first message that tells of the end."""
        begin = getattr(self, "begun", 0.0)
        for _ in range(round(seconds / self.client.time_step)):
            begin += self.client.time_step
            self.client.pose(self.needle, self.needle.base_position + SPEED * begin * self.needle.axis)
            states = self.client.step()
        self.begun = begin
        return self.message(lambda each: each["epoch"] == states.epoch and each["tick"] > states.tick - 10)

    def message(self, wanted):
        deadline = time.monotonic() + PATIENCE
        while self.socket.poll(max(0, 1000 * (deadline - time.monotonic()))):
            topic, payload = self.socket.recv_multipart()
            message = msgpack.unpackb(payload)
            self.assertEqual((topic, message["type"], message["v"]), (b"cloud", "cloud", 2))
            if wanted(message):
                return message
        raise AssertionError("no such message came")

    def test_it_goes_along_and_begins_anew_with_every_epoch(self):
        self.told(self.follow("--worlds", "3", self.scene), "3 worlds go along")
        message = self.go(1.0)
        (needle,) = message["needles"]
        tips = np.frombuffer(needle["tips"]).reshape(-1, 3)
        self.assertEqual((needle["name"], len(tips)), (self.needle.name, 3))
        self.assertAlmostEqual(needle["spread"], spread_of(tips))
        self.assertGreater(needle["spread"], 5e-5)
        self.assertLess(needle["error"], 2e-3)
        self.assertLess(message["behind"], 0.5)
        self.client.reset()
        epoch = self.client.step().epoch
        self.assertEqual(self.message(lambda each: each["epoch"] == epoch)["needles"][0]["spread"], 0.0)  # though the server waits
        self.begun = 0.0
        self.assertLess(self.go(0.06)["needles"][0]["spread"], 1e-6)

    def test_another_scene_than_the_servers_is_told_and_waited_for(self):
        other = small()
        other["tissue.regions[0].material.young_modulus"] = 4e4
        other.save(self.path("other.yaml"))
        program = self.follow("--worlds", "2", self.path("other.yaml"))
        self.told(program, "waits: .*another scene")
        program.terminate()
        self.assertEqual(program.wait(PATIENCE), 0)

    def test_what_cannot_be_is_told_at_once(self):
        for arguments, status, what in ((["--worlds", "1"], 1, "--worlds: expected 2"), (["--uncertain", "stiffness=2"], 1, "NAME=LOW:HIGH"),
                                        (["nosuch"], 1, "no scene 'nosuch'"), (["--publish", "tcp://*:5"], 1, "--publish: expected"),
                                        (["--publish", "ipc:///nosuch/folder"], 3, "--publish ipc:///nosuch/folder"),
                                        (["--uncertain", "stifness=1:2", self.scene], 1, "uncertain: expected stiffness")):
            program = self.follow(*arguments)
            self.assertEqual(program.wait(PATIENCE), status, arguments)
            self.assertIn(what, program.stderr.read())


if __name__ == "__main__":
    unittest.main()
