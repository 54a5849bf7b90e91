#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.Client and acus.Server: servers are started over ipc, most of them in lockstep."""

import os
import signal
import subprocess
import sys
import threading
import time
import unittest

import msgpack
import numpy as np
import zmq

from small_scene import PATIENCE, ROOT, InTemporaryFolder, set_up_for_class

import acus  # noqa: E402
from acus.link import Link  # noqa: E402
from acus.programs import find_program, find_server  # noqa: E402

DOWN = np.array([0, 0, -1.0])


def command_line(pid):
    """Empty of a process that has ended, though nobody may have asked for its status."""
    try:
        with open(f"/proc/{pid}/cmdline", "rb") as file:
            return file.read()
    except FileNotFoundError:
        return b""


class WithWorld(InTemporaryFolder):
    """A server in lockstep and a client of it, for all tests of the class."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        made = set_up_for_class(cls, InTemporaryFolder())
        cls.server = cls.enterClassContext(acus.Server(made.write_scene(), lockstep=True))
        cls.client = cls.enterClassContext(cls.server.client(timeout=PATIENCE))

    def setUp(self):
        super().setUp()
        self.client.release("left", "right", "hole")
        self.client.acquire("left")
        self.client.reset()

    def push(self, depth, ticks=100):
        """The left needle goes down by so much (m); the States of every tick."""
        start, states = self.client.needles[0].base_position, []
        for tick in range(1, ticks + 1):
            self.client.pose("left", start + depth * tick / ticks * DOWN)
            states.append(self.client.step())
        return states


class Lockstep(WithWorld):
    def test_what_is_simulated_is_told_with_types(self):
        hello, described = self.client.hello, self.client.describe()
        self.assertEqual((hello.scene, hello.rate, hello.lockstep, hello.recording), ("small", 200, True, None))
        self.assertEqual([needle.name for needle in self.client.needles], ["left", "right"])
        self.assertEqual([guide.name for guide in self.client.guides], ["hole"])
        np.testing.assert_allclose(self.client.needles[0].tip_position, [0.003, 0.002, 0.06], atol=1e-6)
        self.assertEqual(described.positions.shape, (hello.tissue.nodes, 3))
        self.assertEqual(described.tetrahedra.shape, (hello.tissue.tetrahedra, 4))
        self.assertEqual(described.needles[1].positions.shape, (6, 3))
        self.assertEqual(self.client.refresh().held, ["left"])

    def test_states_of_a_step_have_arrays(self):
        states = self.push(0.04)[-1]
        self.assertEqual(sorted(states), ["left", "right"])
        force = states["left"]
        self.assertEqual((states.tick, states.time, force.phase), (100, 0.5, "inside"))
        for name in ("base_force", "tip_position", "haptic_torque", "guide_force"):
            self.assertEqual(getattr(force, name).shape, (3,))
        self.assertEqual(force.base_orientation.shape, (4,))
        self.assertEqual(force.commanded_orientation.shape, (4,))
        self.assertGreater(force.base_force[2], 0.1)
        self.assertEqual(states["right"].phase, "free")

    def test_events_come_with_the_states(self):
        kinds = [event.kind for states in self.push(0.04) for event in states.events if event.needle == "left"]
        self.assertEqual(kinds, ["contact", "puncture"])

    def test_a_trace_has_every_tick_and_is_the_same_again(self):
        self.push(0.03)
        snapshot = self.client.snapshot()
        first = self.client.trace(50)
        self.assertEqual([states.tick for states in first], list(range(101, 151)))
        self.assertEqual(self.client.restore(snapshot).tick, 100)
        second = self.client.trace(50)
        for one, other in zip(first, second):
            np.testing.assert_array_equal(one["left"].base_force, other["left"].base_force)
        self.assertEqual(second[0].epoch, first[0].epoch + 1)
        self.assertEqual(self.client.lost_states, 0)

    def test_equal_branches_have_equal_hashes(self):
        self.push(0.01)
        snapshot = self.client.snapshot()
        states, hashes = set(), set()
        for start in (snapshot, snapshot.snapshot, snapshot):
            self.client.restore(start)
            states.add(self.client.snapshot().hash)
            self.push(0.02)
            hashes.add(self.client.hash().hash)
        self.assertEqual((len(states), len(hashes)), (1, 1))
        first = []
        for _ in range(2):
            self.client.reset()
            self.push(0.01)
            first.append(self.client.hash().hash)
        self.assertEqual(*first)

    def test_many_ticks_are_one_step(self):
        self.assertEqual(self.client.step(500).tick, 500)
        self.assertRaises(ValueError, self.client.step, 0)

    def test_spin_and_guides_are_commanded(self):
        self.client.spin("left", 0.5)
        self.client.pose("hole", self.client.guides[0].position + [1e-3, 0, 0])
        states = self.client.step(400)
        self.assertAlmostEqual(states["left"].spin, 0.5, places=3)
        self.assertEqual(self.client.refresh().held, ["left", "hole"])

    def test_an_error_has_the_servers_code_and_message(self):
        with self.assertRaises(acus.Refused) as caught:
            self.client.pause()
        self.assertEqual((caught.exception.code, caught.exception.rejected), ("wrong_mode", "pause"))
        self.assertIn(caught.exception.message, str(caught.exception))
        with self.assertRaises(acus.Refused) as caught:
            self.client.restore(b"nonsense")
        self.assertEqual(caught.exception.code, "snapshot_error")
        with self.assertRaises(acus.Refused) as caught:
            self.client.pose("middle", [0, 0, 0])
        self.assertEqual(caught.exception.code, "unknown_needle")

    def test_a_pose_that_is_rejected_is_told_by_the_next_step(self):
        self.client.pose("left", [0, 0, 1000])
        with self.assertRaises(acus.Refused) as caught:
            self.client.step()
        self.assertEqual((caught.exception.code, caught.exception.rejected), ("bad_value", "pose"))
        self.assertEqual(self.client.step().tick, 2)

    def test_a_needle_has_one_holder(self):
        with self.server.client() as other:
            with self.assertRaises(acus.Refused) as caught:
                other.pose("left", [0, 0, 0.2])
            self.assertEqual(caught.exception.code, "held")
            self.assertEqual(other.acquire("right"), ["right"])
        self.client.pose("right", [0.03, 0, 0.2])  # free again with the end of the other's connection

    def test_shapes_come_once_they_are_subscribed_to(self):
        self.client.subscribe("needle", "tissue")
        self.addCleanup(self.client.unsubscribe, "needle", "tissue")
        states = self.client.step(100)
        self.assertEqual((states.shapes["right"].tick, states.tissue.tick), (99, 98))  # every third, every seventh
        self.assertEqual(states.shapes["left"].positions.shape, (6, 3))
        self.assertEqual(states.shapes["left"].orientations.shape, (6, 4))
        self.assertEqual(states.tissue.positions.shape, (64, 3))
        self.assertEqual(states.tissue.paths, [])

    def test_another_scene_is_loaded_by_its_text(self):
        class Text:
            @staticmethod
            def text():
                return "acus_scene: 1\nname: none\nneedles: [{name: alone}]\ntissue: {rung: none}"

        self.addCleanup(self.client.load, os.path.join(os.path.dirname(self.scene_file()), "small.yaml"))
        self.client.load(Text())
        self.assertEqual([needle.name for needle in self.client.needles], ["alone"])
        self.client.pose("alone", [0, 0, 0.3])
        self.assertEqual(sorted(self.client.step()), ["alone"])
        with self.assertRaises(acus.Refused) as caught:
            self.client.load("/nowhere.yaml")
        self.assertEqual(caught.exception.code, "scene_error")

    def scene_file(self):
        with open(f"/proc/{self.server.pid}/cmdline", "rb") as file:
            return file.read().split(b"\0")[1].decode()


class Others(InTemporaryFolder):
    def test_a_client_without_forces_has_ticks(self):
        with acus.Server(self.write_scene(), lockstep=True) as server:
            with server.client(topics=(), timeout=PATIENCE) as client:
                self.assertEqual((client.step(10), client.trace(2)[-1].tick), ({}, 12))


class AsItStands(unittest.TestCase):
    def test_the_shortest_program(self):
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(ROOT)
        position = np.array([-0.003, -0.002, 0.209])
        with acus.Server("scenes/insertion_pullback.yaml", lockstep=True) as server, server.client() as client:
            needle = client.needles[0]
            client.pose(needle.name, position, needle.base_orientation)     # acquires the needle if nobody holds it
            states = client.step(1)                                         # real time: client.wait()
            print(states[needle.name].base_force)


class RealTime(InTemporaryFolder):
    def test_wait_gives_later_ticks_only_and_the_newest(self):
        with acus.Server(self.write_scene()) as server, server.client(timeout=PATIENCE) as client:
            client.pose("left", client.needles[0].base_position)
            first = client.wait()
            second = client.wait()
            self.assertGreater(second.tick, first.tick)
            client.pause()
            self.assertTrue(client.refresh().paused)
            last = second
            with self.assertRaisesRegex(acus.Vanished, "paused"):
                while True:  # those that came before the pause
                    last = client.wait(timeout=1)
            client.resume()
            self.assertGreater(client.wait().tick, last.tick)
            self.assertRaisesRegex(acus.Refused, "wrong_mode", client.step)

    def test_a_client_finds_the_next_start_of_its_server(self):
        program, scene = find_server(), self.write_scene()
        endpoints = ["ipc://" + self.path("commands"), "ipc://" + self.path("states")]

        def start():
            command = [program, scene, "--commands", endpoints[0], "--states", endpoints[1], "--log-level", "error"]
            process = subprocess.Popen(command)
            self.addCleanup(process.wait)
            self.addCleanup(process.kill)
            return process

        before = start()
        with acus.Client(*endpoints, timeout=PATIENCE) as client:
            instance = client.hello.instance
            client.pose("left", client.needles[0].base_position)
            self.assertGreater(client.wait().tick, 0)
            client.reset()  # an epoch that the next server does not have
            before.kill()
            before.wait()
            self.assertRaises(acus.Vanished, client._ask, "hash", acus.HashReply, timeout=0.1)
            start()
            self.assertEqual(client.wait().epoch, 0)
            client.pose("left", client.needles[0].base_position)  # acquires it anew
            self.assertEqual(client.reconnections, 1)
            self.assertNotEqual(client.hello.instance, instance)
            while client.wait()["left"].seq == 0:
                pass
            self.assertEqual(client.refresh().held, ["left"])

    def test_nobody_there(self):
        begun = time.monotonic()
        with self.assertRaisesRegex(acus.Vanished, "nobody is there"):
            acus.Client("ipc://" + self.path("c"), "ipc://" + self.path("s"), timeout=0.2)
        self.assertLess(time.monotonic() - begun, PATIENCE)
        self.assertRaises(acus.ClientError, acus.Client, "nonsense", "nonsense", timeout=0.2)

    def test_somebody_else_there(self):
        with zmq.Context() as context, context.socket(zmq.ROUTER) as router:
            router.bind("ipc://" + self.path("commands"))
            for answer in (b"\xc1", msgpack.packb([1]), msgpack.packb({"v": 2, "type": "hello_reply", "seq": 1}),
                           msgpack.packb({"v": 3, "type": "error", "seq": 1, "code": "wrong_version", "message": "no",
                                          "rejected": "hello"})):
                thread = threading.Thread(target=lambda: router.send_multipart([router.recv_multipart()[0], answer]))
                thread.start()
                self.assertRaises(acus.ProtocolMismatch, acus.Client, "ipc://" + self.path("commands"),
                                  "ipc://" + self.path("states"), timeout=PATIENCE)
                thread.join()


class WaitingForAPeer(InTemporaryFolder):
    def test_a_question_between_two_looks_loses_no_event(self):
        """Else a client that asks whether it is refused right as it is admitted would wait for its peer for ever."""
        context = zmq.Context()
        self.addCleanup(context.destroy, linger=0)
        peer = context.socket(zmq.ROUTER)
        endpoint = f"ipc://{self.folder}/peer"
        peer.bind(endpoint)
        link = Link(context, zmq.DEALER, endpoint)
        self.addCleanup(link.close)
        self.assertTrue(link.monitor.poll(1000 * PATIENCE))
        self.assertFalse(link.refused())
        self.assertTrue(link.monitor.poll(0))
        self.assertTrue(link.connected())


class WithKeys(InTemporaryFolder):
    def setUp(self):
        super().setUp()
        for name in ("server", "alice", "bob"):
            subprocess.run([find_program("acus-keygen"), self.path(name)], check=True, stdout=subprocess.DEVNULL)

    def keys(self, client, server="server"):
        return acus.Keys(self.path(server + ".key"), self.path(client + ".key_secret"))

    def test_a_client_that_is_not_admitted_is_told_why(self):
        options = ["--curve-server-key", self.path("server.key_secret"), "--curve-clients", self.path("alice.key")]
        with acus.Server(self.write_scene(), lockstep=True, options=options, keys=self.keys("alice")) as server:
            with server.client() as client:
                self.assertEqual(client.step().tick, 1)
            for keys, reason in ((self.keys("bob"), "refuses this client's key"), (None, "only clients with keys")):
                with self.assertRaisesRegex(acus.KeysRefused, reason):
                    server.client(keys=keys, timeout=PATIENCE)
            self.assertIn("ended in the handshake", self.reason_after_an_attempt(server))
        with acus.Server(self.write_scene(), lockstep=True) as server:
            with self.assertRaisesRegex(acus.KeysRefused, "does not use keys"):
                server.client(keys=self.keys("alice"), timeout=PATIENCE)

    def reason_after_an_attempt(self, server):
        """Why nobody answers to the wrong key of a server; on a busy machine there may be no attempt within the
        time."""
        for _ in range(PATIENCE):
            with self.assertRaises(acus.Vanished) as caught:
                server.client(keys=self.keys("alice", server="bob"), timeout=1)
            if "nobody is there" not in str(caught.exception):
                break
        return str(caught.exception)

    def test_files_that_hold_no_keys_are_named(self):
        self.assertRaisesRegex(acus.KeyFileError, "secret key", acus.Keys, self.path("server.key_secret"),
                               self.path("alice.key_secret"))
        self.assertRaisesRegex(acus.KeyFileError, "cannot be read", acus.Keys, self.path("server.key"),
                               self.path("nobody"))


class Starting(InTemporaryFolder):
    def test_what_cannot_start_says_why(self):
        with self.assertRaises(acus.ServerFailed) as caught:
            acus.Server(self.write("bad.yaml", "acus_scene: 1\nrate: fast\n"))
        self.assertEqual(caught.exception.status, 2)
        self.assertIn("rate: expected a number", str(caught.exception))
        self.assertIn("rate: expected a number", caught.exception.log)
        self.assertRaises(acus.ProgramNotFound, acus.Server, self.write_scene(), program="/nowhere/acus-server")

    def test_rate_and_options_reach_the_server(self):
        with acus.Server(self.write_scene(), lockstep=True, rate=50, options=["--recordings", self.folder]) as server:
            with server.client() as client:
                self.assertEqual(client.hello.rate, 50)
                client.record("run.acus")
                client.step(10)
                client.end_recording()
            self.assertTrue(os.path.exists(self.path("run.acus")))
            self.assertIn("lockstep", server.log)
            self.assertTrue(server.running)
        self.assertEqual(server.end(), 0)
        self.assertFalse(server.running or os.path.exists(server.folder))
        self.assertIn("lockstep", server.log)

    def test_no_server_outlives_its_interpreter(self):
        for ending in ("pass", "raise SystemExit(3)", *(f"os.kill(os.getpid(), signal.{name})"
                                                        for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGKILL"))):
            script = ("import os, signal, sys\nsys.path.insert(0, sys.argv[1])\nimport acus\n"
                      f"server = acus.Server(sys.argv[2])\nprint(server.pid, server.folder, flush=True)\n{ending}\n")
            done = subprocess.run([sys.executable, "-c", script, os.path.join(ROOT, "client", "python"),
                                   self.write_scene()], capture_output=True, text=True, timeout=PATIENCE, check=False)
            pid, folder = done.stdout.split()
            end = time.monotonic() + PATIENCE
            while os.path.exists(folder) and time.monotonic() < end:  # the guard of one that was killed takes a moment
                time.sleep(0.02)
            self.assertFalse(os.path.exists(folder), done.stderr)
            self.assertEqual(command_line(pid), b"")

    def test_where_the_program_is_looked_for(self):
        fake = self.write("acus-server", "#!/bin/sh\nexit 7\n")
        os.chmod(fake, 0o755)
        before = os.environ.get("ACUS_SERVER")
        self.addCleanup(lambda: os.environ.pop("ACUS_SERVER") if before is None else
                        os.environ.__setitem__("ACUS_SERVER", before))
        os.environ["ACUS_SERVER"] = fake
        self.assertEqual(find_server(), fake)
        self.assertRaisesRegex(acus.ServerFailed, "status 7", acus.Server, self.write_scene())
        self.assertEqual(find_server(sys.executable), sys.executable)
        self.assertRaises(acus.ProgramNotFound, find_program, "acus-of-no-kind")


if __name__ == "__main__":
    unittest.main()
