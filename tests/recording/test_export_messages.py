#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What acus-export --messages writes of a recorded run is what a viewer would have been sent of it: compared with the
forces and events of every tick, and with the shapes that the server published.

Usage: test_export_messages.py BINARIES."""

import os
import subprocess
import sys
import unittest

import msgpack
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "python"))
from small_scene import PATIENCE, InTemporaryFolder, set_up_for_class  # noqa: E402

import acus  # noqa: E402
from acus import messages  # noqa: E402

BINARIES = sys.argv.pop()
DOWN = np.array([0, 0, -1.0])
KINDS = {"hello_reply": messages.HelloReply, "describe_reply": messages.DescribeReply, "force": messages.Force,
         "needle": messages.NeedleShape, "tissue": messages.TissueShape, "event": messages.Event}


def export(*arguments):
    return subprocess.run([f"{BINARIES}/acus-export", *arguments], capture_output=True, text=True, timeout=PATIENCE,
                          check=False)


def read(path):
    with open(path, "rb") as file:
        return list(msgpack.Unpacker(file, max_buffer_size=2**30))


def frames_of(told):
    """The messages after hello and description, cut behind each tissue state; and what stands behind the last of these."""
    frames = [[]]
    for message in told[2:]:
        frames[-1].append(message)
        if message["type"] == "tissue":
            frames.append([])
    return frames[:-1], frames[-1]


def of_kind(told, kind, needle=None):
    return [message for message in told if message["type"] == kind and needle in (None, message.get("needle"))]


def place(message):
    return message["epoch"], message["tick"]


def size(force):
    return np.linalg.norm(force["base_force"])


class Messages(InTemporaryFolder):
    """The left needle goes 40 mm down in 100 ticks at 200 Hz; then the simulation begins anew, for 21 ticks; then there is
    another scene."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        made = cls.made = set_up_for_class(cls, InTemporaryFolder())
        cls.recording = made.path("run.acus")
        with acus.Server(made.write_scene(), lockstep=True, options=["--recordings", made.folder],
                         program=f"{BINARIES}/acus-server") as server:
            with server.client(timeout=PATIENCE) as client:
                start = client.needles[0].base_position
                client.reset()
                client.record("run.acus")
                for tick in range(100):
                    client.pose("left", start + 4e-4 * tick * DOWN)
                    client.step()
                client.reset()
                for _ in range(21):
                    client.step()
                client.load(made.write_scene("other"))
                client.step(10)
                client.end_recording()
                client.record("short.acus")
                client.step(10)
                client.end_recording()
        cls.file = made.path("run.messages")
        cls.result = export(cls.recording, "--messages", cls.file, "--csv", made.path("run.csv"))
        cls.told = read(cls.file)
        cls.run_of_all = acus.Run(made.path("run.csv"))

    def ticks_of_all(self):
        """(epoch, tick, magnitude of the left needle's force) of each tick of the first scene."""
        left = [self.run_of_all.of_epoch(number)["left"] for number in (1, 2)]
        return [(number, tick, np.linalg.norm(force)) for number, forces in zip((1, 2), left)
                for tick, force in zip(forces.tick, forces.base_force)]

    def test_the_run_is_the_same(self):
        self.assertEqual(self.result.returncode, 0, self.result.stderr)

    def test_messages_are_those_of_the_protocol(self):
        self.assertEqual([message["type"] for message in self.told[:2]], ["hello_reply", "describe_reply"])
        for message in self.told:
            self.assertEqual(message["v"], 2)
            KINDS[message["type"]](message)  # which finds all its fields
        hello, describe = self.told[:2]
        self.assertEqual((hello["scene"], hello["epoch"], describe["epoch"]), ("small", 1, 1))
        rates = {topic["name"]: topic["rate"] for topic in hello["topics"]}
        self.assertEqual((rates["needle"], rates["tissue"]), (60, 60))

    def test_a_frame_has_forces_and_events_by_tick_then_all_shapes(self):
        for frame in frames_of(self.told)[0]:
            kinds = [message["type"] for message in frame]
            self.assertEqual(kinds[-3:], ["needle", "needle", "tissue"])
            self.assertEqual([message["needle"] for message in frame[-3:-1]], ["left", "right"])
            self.assertLessEqual(set(kinds[:-3]), {"force", "event"})
            places = [(*place(message), message["type"] == "event") for message in frame[:-3]]
            self.assertEqual(places, sorted(places))
            last = of_kind(frame, "force", "right")[-1]
            self.assertEqual({place(message) for message in frame[-3:]}, {place(last)})

    def test_frames_come_at_their_rate_as_long_as_the_scene_is_there(self):
        frames, rest = frames_of(self.told)
        ticks = [place(frame[-1]) for frame in frames]
        self.assertEqual(ticks[:4], [(1, 1), (1, 3), (1, 7), (1, 10)])
        self.assertEqual(ticks[-1], (2, 20))  # 121 ticks are 36.3 frames
        self.assertEqual(len(ticks), 37)
        self.assertEqual([(message["type"], *place(message)) for message in rest], [("force", 2, 21)] * 2)

    def test_a_run_ends_with_a_frame(self):
        file = self.path("short.messages")
        self.assertEqual(export(self.made.path("short.acus"), "--messages", file, "--rate", "30").returncode, 0)
        frames, rest = frames_of(read(file))
        self.assertEqual(([frame[-1]["tick"] for frame in frames], rest), ([11, 17, 20], []))

    def test_of_the_forces_in_between_the_smallest_the_largest_and_the_last_are_there(self):
        rest = self.ticks_of_all()
        frames, tail = frames_of(self.told)
        for frame in [*frames, tail]:
            forces = of_kind(frame, "force", "left")
            end = next(i for i, (epoch, tick, _) in enumerate(rest) if (epoch, tick) == place(forces[-1])) + 1
            between, rest = rest[:end], rest[end:]
            sizes = [force for _, _, force in between]
            wanted = {between[i][:2] for i in (int(np.argmin(sizes)), int(np.argmax(sizes)), -1)}
            self.assertEqual([place(force) for force in forces], sorted(wanted))
            of_tick = {(epoch, tick): force for epoch, tick, force in between}
            for force in forces:
                self.assertAlmostEqual(size(force), of_tick[place(force)], places=12)
                self.assertEqual(force["haptic_force"], force["base_force"])
        self.assertEqual(rest, [])

    def test_every_event_is_there(self):
        events = [(message["epoch"], message["tick"], message["kind"]) for message in of_kind(self.told, "event")]
        self.assertEqual([kind for _, _, kind in events], ["contact", "puncture"])
        known = [(1, event.tick, event.kind) for event in self.run_of_all.of_epoch(1).events]
        self.assertEqual(events, known)

    def test_another_rate_gives_other_frames_of_the_same_run(self):
        other = self.path("other.messages")
        self.assertEqual(export(self.recording, "--messages", other, "--rate", "1000").returncode, 0)
        every = read(other)
        self.assertEqual(len(of_kind(every, "tissue")), 121)  # one for each tick
        self.assertEqual(len(of_kind(every, "force", "left")), 121)
        self.assertEqual(of_kind(every, "event"), of_kind(self.told, "event"))
        known = {(place(shape), shape["needle"]): shape for shape in of_kind(every, "needle")}
        for shape in of_kind(self.told, "needle"):
            self.assertEqual(shape, known[place(shape), shape["needle"]])

    def test_a_rate_wants_frames_and_files_want_names_of_their_own(self):
        alone = export(self.recording, "--rate", "30")
        self.assertEqual(alone.returncode, 1)
        self.assertIn("--vtk or --messages", alone.stderr)
        same = self.path("same")
        twice = export(self.recording, "--messages", same, "--shapes", same)
        self.assertEqual(twice.returncode, 3)
        self.assertIn("--shapes and --messages", twice.stderr)
        before = os.path.getsize(self.recording)
        self.assertEqual(export(self.recording, "--messages", self.recording).returncode, 3)
        self.assertEqual(os.path.getsize(self.recording), before)
        self.assertEqual(export(self.recording, "--messages", "/nowhere/run").returncode, 3)


if __name__ == "__main__":
    unittest.main()
