#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of the Python scripts: the trajectory generator, the converter of hand motions, and the plot."""

import csv
import math
import os
import subprocess
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
RECORDING = os.path.join(ROOT, "..", "shared", "data", "hand_motion", "recording1.txt")


def run(script, *arguments):
    command = [os.path.join(ROOT, script), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def read_rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def floats(row, names):
    return [float(row[name]) for name in names]


def distance(a, b):
    return math.dist(a, b)


class InTemporaryFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def assert_success(self, result):
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)


class MakeTrajectory(InTemporaryFolder):
    def test_the_committed_trajectory_is_what_the_script_makes(self):
        self.assert_success(run("scripts/make-trajectory", "--out", self.path("made.csv")))
        committed = os.path.join(ROOT, "scenes", "trajectories", "insertion_pullback.csv")
        with open(self.path("made.csv"), encoding="ascii") as made, open(committed, encoding="ascii") as kept:
            self.assertEqual(made.read(), kept.read())


class ConvertHandMotion(InTemporaryFolder):
    def convert(self, recording, *arguments):
        return run("client/convert_hand_motion.py", recording, "--out", self.path("out.csv"), *arguments)

    def write_recording(self, rows):
        with open(self.path("recording.txt"), "w", encoding="ascii") as file:
            file.writelines(" ".join(map(str, row)) + "\n" for row in rows)
        return self.path("recording.txt")

    def test_the_principal_way_is_aimed_and_scaled(self):
        recording = self.write_recording([(10, 20 + 2 * i, 30, 1, 0, 0, 0) for i in range(51)])  # 100 mm along y
        self.assert_success(self.convert(recording, "--start", "1", "2", "3", "--direction", "0", "0", "-2",
                                         "--travel", "0.06", "--needle", "left"))
        rows = read_rows(self.path("out.csv"))
        self.assertEqual(len(rows), 51)
        self.assertEqual(rows[0]["needle"], "left")
        self.assertAlmostEqual(float(rows[50]["t"]), 1.0)
        self.assertLess(distance(floats(rows[0], "xyz"), (1, 2, 3)), 1e-8)
        self.assertLess(distance(floats(rows[50], "xyz"), (1, 2, 2.94)), 1e-8)

    def axes_after_turning(self, *arguments):
        """Where the needle points first and last when the tool turns by 30 degrees about x, across its way along y."""
        half = math.radians(30) / 2
        recording = self.write_recording([(0, 0, 0, 1, 0, 0, 0), (0, 10, 0, -math.cos(half), -math.sin(half), 0, 0)])
        self.assert_success(self.convert(recording, "--direction", "0", "0", "-1", *arguments))
        quaternions = [floats(row, ["qw", "qx", "qy", "qz"]) for row in read_rows(self.path("out.csv"))]
        return [(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)) for w, x, y, z in quaternions]

    def test_the_needle_turns_as_the_tool_did_about_the_direction(self):
        for factor, degrees in ((1, 30), (0.5, 15), (0, 0)):
            first, last = self.axes_after_turning("--turn", str(factor))
            cosine = sum(a * b for a, b in zip(first, last))
            self.assertAlmostEqual(cosine, math.cos(math.radians(degrees)), places=6)
            middle = [(a + b) / 2 for a, b in zip(first, last)]
            self.assertAlmostEqual(middle[2], -math.cos(math.radians(degrees / 2)), places=6)

    def test_bad_rows_are_named(self):
        recording = self.write_recording([(0, 0, 0, 1, 0, 0, 0), (0, 0, "x", 1, 0, 0, 0)])
        result = self.convert(recording)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("recording.txt:2:", result.stderr)

    def test_a_tool_that_rests_has_no_way(self):
        result = self.convert(self.write_recording([(0, 0, 0, 1, 0, 0, 0)] * 2))
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("does not move", result.stderr)

    @unittest.skipUnless(os.path.exists(RECORDING), "no ../shared/data beside the source")
    def test_a_measured_motion(self):
        self.assert_success(self.convert(RECORDING, "--start", "0", "0", "0.2", "--travel", "0.05"))
        rows = read_rows(self.path("out.csv"))
        lowest = min(float(row["z"]) for row in rows)
        self.assertEqual(len(rows), 507)
        self.assertAlmostEqual(lowest, 0.15, places=6)


class Plot(InTemporaryFolder):
    VECTORS = ("base_position_m", "base_force_N", "cutting_force_N", "friction_force_N", "lateral_force_N")

    def write_run(self):
        """A needle along +x that goes 40 mm in, rests, and comes out; friction grows with depth."""
        names = ["time_s", "needle", "phase", "depth_m"] + [f"base_orientation_{c}" for c in "wxyz"]
        for vector in self.VECTORS:
            stem, unit = vector.rsplit("_", 1)
            names += [f"{stem}_{c}_{unit}" for c in "xyz"]
        with open(self.path("run.csv"), "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, names, restval=0)
            writer.writeheader()
            for i in range(300):
                depth = 4e-4 * min(i, 100, 300 - i) if i < 200 else 4e-4 * (300 - i)
                force = -20 * depth if i < 100 else 20 * depth if i >= 200 else -10 * depth
                writer.writerow({"time_s": 0.01 * i, "needle": "needle", "phase": "inside" if depth > 0 else "free",
                                 "depth_m": depth, "base_orientation_w": 1, "base_position_x_m": depth,
                                 "base_force_x_N": force, "friction_force_x_N": force})

    def test_a_run_becomes_a_picture(self):
        self.write_run()
        with open(self.path("run.events.csv"), "w", encoding="utf-8") as file:
            file.write("time_s,needle,kind\n0.01,needle,puncture\n2.99,needle,withdrawal\n")
        for depth in ("travel", "inserted"):
            out = self.path(depth + ".png")
            self.assert_success(run("client/plot", self.path("run.csv"), "--out", out, "--depth", depth))
            self.assertGreater(os.path.getsize(out), 10_000)

    def test_the_picture_stands_beside_the_run_by_default(self):
        self.write_run()
        self.assert_success(run("client/plot", self.path("run.csv")))
        self.assertTrue(os.path.exists(self.path("run.png")))

    def test_what_is_no_run_is_told(self):
        for name, text in (("empty.csv", ""), ("other.csv", "a,b\n1,2\n")):
            with open(self.path(name), "w", encoding="utf-8") as file:
                file.write(text)
            result = run("client/plot", self.path(name))
            self.assertNotEqual(result.returncode, 0)
            self.assertIn("expected a run written by acus-replay", result.stderr)
        self.assertIn("No such file", run("client/plot", self.path("missing.csv")).stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
