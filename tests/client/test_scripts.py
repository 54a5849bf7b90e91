#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of the Python scripts: the trajectory generator, the converter of hand motions, the plots and the picture."""

import csv
import math
import os
import subprocess
import sys
import tempfile
import unittest

import msgpack
import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "client", "python"))

import acus  # noqa: E402
from acus import shapes  # noqa: E402
from acus.drawing import run_curves  # noqa: E402

RECORDING = os.path.join(ROOT, "..", "shared", "data", "hand_motion", "recording1.txt")


def run(script, *arguments):
    command = [os.path.join(ROOT, script), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def read_rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


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


class MakeTrajectories(InTemporaryFolder):
    def test_the_committed_trajectories_are_what_the_script_makes(self):
        self.assert_success(run("scenes/make-trajectories", "--out", self.folder))
        names = os.listdir(self.folder)
        self.assertIn("insertion_pullback.csv", names)
        for name in names:
            homes = [os.path.join(ROOT, "scenes", folder, name) for folder in ("trajectories", "benchmark")]
            committed = next(filter(os.path.exists, homes), homes[0])
            with open(self.path(name), encoding="ascii") as made, open(committed, encoding="ascii") as kept:
                self.assertEqual(made.read(), kept.read(), name)


class ConvertHandMotionCase(InTemporaryFolder):
    def convert(self, recording, *arguments):
        return run("client/replay/convert_hand_motion.py", recording, "--out", self.path("out.csv"), *arguments)

    def write_recording(self, rows):
        with open(self.path("recording.txt"), "w", encoding="ascii") as file:
            file.writelines(" ".join(map(str, row)) + "\n" for row in rows)
        return self.path("recording.txt")


class ConvertHandMotion(ConvertHandMotionCase):
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

    def test_its_own_file_is_replaced_and_no_other(self):
        recording = self.write_recording([(0, 10 * i, 0, 1, 0, 0, 0) for i in range(3)])
        for _ in range(2):
            self.assert_success(self.convert(recording))
        with open(self.path("out.csv"), "a", encoding="utf-8") as file:
            file.write("1,needle,0,0,0,1,0,0,0,0\n")
        result = self.convert(recording)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("or it was edited, and would be lost", result.stderr)

    def test_bad_rows_are_named(self):
        recording = self.write_recording([(0, 0, 0, 1, 0, 0, 0), (0, 0, "x", 1, 0, 0, 0)])
        result = self.convert(recording)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("recording.txt:2:", result.stderr)

    def test_a_tool_that_rests_has_no_way(self):
        result = self.convert(self.write_recording([(0, 0, 0, 1, 0, 0, 0)] * 2))
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("does not move", result.stderr)


@unittest.skipUnless(os.path.exists(RECORDING), "SKIPPED: ../shared/data is not beside the sources")
class ConvertMeasuredMotion(ConvertHandMotionCase):
    def test_a_measured_motion(self):
        self.assert_success(self.convert(RECORDING, "--start", "0", "0", "0.2", "--travel", "0.05"))
        rows = read_rows(self.path("out.csv"))
        lowest = min(float(row["z"]) for row in rows)
        self.assertEqual(len(rows), 507)
        self.assertAlmostEqual(lowest, 0.15, places=6)


class RecordedRun(InTemporaryFolder):
    """A needle along +x that goes 40 mm in, rests, and comes out within 3 s; friction grows with depth."""

    VECTORS = ("base_position_m", "base_force_N", "cutting_force_N", "friction_force_N", "lateral_force_N")

    @staticmethod
    def depth_at(i):
        return 4e-4 * min(i, 100) if i < 200 else 4e-4 * (300 - i)

    def write_run(self):
        names = ["time_s", "needle", "phase", "depth_m"] + [f"base_orientation_{c}" for c in "wxyz"]
        for vector in self.VECTORS:
            stem, unit = vector.rsplit("_", 1)
            names += [f"{stem}_{c}_{unit}" for c in "xyz"]
        with open(self.path("run.csv"), "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, names, restval=0)
            writer.writeheader()
            for i in range(300):
                depth = self.depth_at(i)
                force = -20 * depth if i < 100 else 20 * depth if i >= 200 else -10 * depth
                writer.writerow({"time_s": 0.01 * i, "needle": "needle", "phase": "inside" if depth > 0 else "free",
                                 "depth_m": depth, "base_orientation_w": 1, "base_position_x_m": depth,
                                 "base_force_x_N": force, "friction_force_x_N": force})


class Plot(RecordedRun):
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

    def test_events_that_repeat_are_drawn_once(self):
        self.write_run()
        with open(self.path("run.events.csv"), "w", encoding="utf-8") as file:
            rows = [(0.5 + 0.01 * i, "needle", kind) for i in range(30) for kind in ("contact", "release")]
            rows += [(2, "needle", "contact"), (2, "other", "contact")]
            file.write("time_s,needle,kind\n" + "".join("{},{},{}\n".format(*row) for row in rows))
        drawn = acus.Run(self.path("run.csv"))
        events = run_curves.events_to_draw(drawn, run_curves.Curves(drawn))
        self.assertEqual([(event.time, event.needle, event.kind) for event in events],
                         [(0.5, "needle", "contact"), (0.5, "needle", "release"), *rows[-2:]])

    def test_what_is_no_run_is_told(self):
        for name, text in (("empty.csv", ""), ("other.csv", "a,b\n1,2\n")):
            with open(self.path(name), "w", encoding="utf-8") as file:
                file.write(text)
            result = run("client/plot", self.path(name))
            self.assertNotEqual(result.returncode, 0)
            self.assertIn("expected a run written by acus-replay", result.stderr)
        self.assertIn("No such file", run("client/plot", self.path("missing.csv")).stderr)


class Jumps(InTemporaryFolder):
    COLUMNS = ("tick", "time_s", "needle", "phase", "depth_m", "base_force_in_base_x_N", "base_force_in_base_y_N",
               "base_force_in_base_z_N", "flags")

    def write_forces(self, ticks, forces, flags=0):
        with open(self.path("run.csv"), "w", encoding="utf-8") as file:
            rows = [(tick, 1e-3 * tick, "needle", "inside", 0.01, force, 0, 0, flags)
                    for tick, force in zip(ticks, forces)]
            file.writelines(",".join(map(str, row)) + "\n" for row in [self.COLUMNS, *rows])

    def write_events(self, *events):
        with open(self.path("run.events.csv"), "w", encoding="utf-8") as file:
            file.writelines(",".join(map(str, row)) + "\n" for row in [("tick", "time_s", "needle", "kind"), *events])

    def jumps(self, *arguments):
        return run("client/plot", self.path("run.csv"), "--jumps", *arguments)

    def test_a_step_is_found_with_its_time_and_a_ramp_is_none(self):
        self.write_forces(range(100), [-1e-1 * max(0, i - 50) - (0.3 if i >= 20 else 0) for i in range(100)])
        lines = self.jumps("2").stdout.splitlines()
        self.assertEqual(lines[1].split()[:3], ["0.0200", "needle", "0.3000"])
        self.assertEqual(lines[1].split()[-1], "none")
        self.assertEqual(lines[2].split()[2], "0.0000")

    def test_an_event_explains_a_jump_and_flags_are_named(self):
        self.write_forces(range(100), [-0.3 if i >= 20 else 0 for i in range(100)], flags=8)
        self.assertIn("flags 8", self.jumps("1").stdout)
        self.assertEqual(self.jumps("--above", "0.05").returncode, 1)
        self.write_events((19, 0.019, "needle", "puncture"), (20, 0.02, "other", "contact"))
        result = self.jumps("--above", "0.05")
        self.assert_success(result)
        self.assertTrue(result.stdout.splitlines()[1].endswith("puncture"))

    def test_a_contact_is_named_and_explains_no_jump(self):
        self.write_forces(range(100), [-0.3 if i >= 20 else 0 for i in range(100)])
        self.write_events((20, 0.02, "needle", "contact"))
        result = self.jumps("--above", "0.05")
        self.assertEqual(result.returncode, 1)
        self.assertTrue(result.stdout.splitlines()[1].endswith("contact"))
        self.write_events((20, 0.02, "needle", "contact"), (20, 0.02, "needle", "crossing"))
        self.assert_success(self.jumps("--above", "0.05"))

    def test_what_lies_between_lost_ticks_is_no_jump(self):
        self.write_forces([*range(20), *range(40, 60)], [0] * 20 + [1] * 20)
        self.assert_success(self.jumps("--above", "0.05"))

    def test_what_is_no_run_is_told(self):
        self.write_forces(range(3), [0, 0, "x"])
        self.assertIn("not a whole run", self.jumps().stderr)
        self.assertIn("no needle 'other'", self.jumps("--needle", "other").stderr)


class PlotTiming(InTemporaryFolder):
    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    def write_timing(self):
        trips = "".join(f"{i},{1e-3 * i},{0.9e-3 + 1e-6 * (i % 100)}\n" for i in range(1, 2000))
        self.write("timing.csv", "seq,sent_s,round_trip_s\n" + trips)
        names = [f"{what}_{q}_s" for what in ("wake", "end") for q in ("p50", "p99", "max")]
        rows = "".join(f"{second},0.001,1000,{second},1e-5,2e-5,3e-4,5e-4,7e-4,1.2e-3\n" for second in range(1, 5))
        self.write("timing.stats.csv", "received_s,time_step_s,ticks,late," + ",".join(names) + "\n" + rows)

    def test_a_run_becomes_a_picture(self):
        self.write_timing()
        self.assert_success(run("client/plot", self.path("timing.csv")))
        self.assertGreater(os.path.getsize(self.path("timing.png")), 10_000)

    def test_what_is_no_timing_is_told(self):
        self.write_timing()
        self.write("timing.stats.csv", "a,b\n1,2\n")
        result = run("client/plot", self.path("timing.csv"))
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("expected a column 'time_step_s'", result.stderr)
        self.write("timing.csv", "seq,sent_s,round_trip_s\n")
        self.assertIn("found no rows", run("client/plot", self.path("timing.csv")).stderr)
        self.assertIn("missing.csv", run("client/plot", self.path("missing.csv")).stderr)


def block(cells, size):
    """Nodes and tetrahedra of a cube from the origin, six tetrahedra to a cell."""
    grid = np.arange((cells + 1) ** 3).reshape([cells + 1] * 3)
    ticks = np.linspace(0, size, cells + 1)
    nodes = np.stack(np.meshgrid(ticks, ticks, ticks, indexing="ij"), axis=-1).reshape(-1, 3)
    tetrahedra = []
    for first, second in ((0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)):
        corner = [0, 0, 0]
        corners = [tuple(corner)]
        for axis in (first, second, 3 - first - second):
            corner[axis] = 1
            corners.append(tuple(corner))
        tetrahedra.append(np.stack([grid[tuple(slice(c, c + cells) for c in at)].ravel() for at in corners], axis=1))
    return nodes, np.concatenate(tetrahedra)


class Cut(unittest.TestCase):
    def total_area(self, cells, point, normal):
        nodes, tetrahedra = block(cells, 2.0)
        polygons, owners = shapes.cut(nodes, tetrahedra, np.array(point), np.array(normal) / np.linalg.norm(normal))
        self.assertEqual(len(polygons), len(owners))
        for polygon in polygons:
            self.assertLess(np.max(np.abs((polygon - point) @ normal)), 1e-12)
        return sum(float(shapes.area(polygon[None])[0]) for polygon in polygons)

    def test_the_polygons_fill_the_cut_once(self):
        for point, normal, area in (((0, 0, 0.7), (0, 0, 1), 4), ((0, 0, 1), (0, 0, 1), 4), ((0, 0, 1), (0, 0, -1), 4),
                                    ((1, 1, 1), (1, -1, 0), 4 * math.sqrt(2)),
                                    ((1, 1, 1), (1, 1, 1), 3 * math.sqrt(3))):  # a regular hexagon of edge sqrt(2)
            for cells in (1, 2, 3):
                with self.subTest(point=point, normal=normal, cells=cells):
                    self.assertAlmostEqual(self.total_area(cells, point, normal), area)

    def test_a_plane_that_misses_cuts_nothing(self):
        self.assertEqual(self.total_area(2, (0, 0, 3), (0, 0, 1)), 0)

    def test_a_polygon_belongs_to_its_tetrahedron(self):
        nodes, tetrahedra = block(3, 1.0)
        polygons, owners = shapes.cut(nodes, tetrahedra, np.array([0.4, 0.4, 0.4]), np.array([0.6, 0.0, 0.8]))
        for polygon, owner in zip(polygons, owners):
            corners = nodes[tetrahedra[owner]]
            shares = np.linalg.solve(np.vstack([corners.T, np.ones(4)]), np.append(polygon.mean(axis=0), 1))
            self.assertGreater(shares.min(), 0)


class Centroids(unittest.TestCase):
    def test_tetrahedra_count_with_their_volume(self):
        nodes, tetrahedra = block(4, 1.0)
        nodes = nodes**2  # small cells at the origin, large ones away from it
        regions = np.zeros(len(tetrahedra), dtype=int)
        np.testing.assert_allclose(shapes.node_shares(nodes, tetrahedra, regions, 1) @ nodes, [[0.5, 0.5, 0.5]])


class Picture(RecordedRun):
    """The run's needle enters a cube of two regions at x = 0, where its path begins; another one stands aside."""

    def write_shapes(self):
        nodes, tetrahedra = block(4, 0.1)
        nodes = nodes - [0, 0.05, 0.05]
        needle = {"length": 0.1, "diameter": 1e-3, "nodes": 11, "base_position": [0, 0, 0],
                  "base_orientation": [1, 0, 0, 0]}
        guide = {"name": "collar", "needle": "needle", "position": [-0.02, 0, 0], "orientation": [1, 0, 0, 0]}
        messages = [
            {"type": "hello_reply", "scene": "made up", "guides": [guide],
             "needles": [{"name": "needle", **needle}, {"name": "other", **needle}]},
            {"type": "describe_reply", "positions": packed(nodes, "<f4"), "regions": ["near", "far"],
             "tetrahedra": packed(tetrahedra, "<i4"),
             "tetrahedron_regions": packed(nodes[tetrahedra].mean(axis=1)[:, 0] > 0.05, "<i4")}]
        for i in range(0, 300, 5):
            depth, state = self.depth_at(i), {"time": 0.01 * i}
            messages.append({**guide, "type": "pose", "needle": "collar", "position": [-0.02, 1e-5 * i, 0]})
            stretched = nodes * [1 + 0.25 * depth, 1, 1]  # by 1 % when the needle is 40 mm in
            messages.append({"type": "tissue", "positions": packed(stretched, "<f4"),
                             "path_sizes": packed([2, 1], "<i4"), **state,
                             "path_points": packed([0, 0, 0, depth, 0, 0, 0.01, 0.02, 0], "<f4"),
                             "dent_centres": packed([depth, 0, 0], "<f4"), "dent_moves": packed([1e-3, 0, 0], "<f4"),
                             "dent_radii": packed([1e-3, 5e-3], "<f4")})
            for name, y in (("needle", 0.0), ("other", 0.03)):
                points = [[depth - 0.01 * k, y, 0] for k in reversed(range(11))]
                messages.append({"type": "needle", "needle": name, "positions": packed(points, "<f8"),
                                 "orientations": packed([[1, 0, 0, 0]] * 11, "<f8"), **state})
        with open(self.path("run.shapes"), "wb") as file:
            file.writelines(msgpack.packb({"v": 2, **message}) for message in messages)

    def write_all(self):
        self.write_run()
        self.write_shapes()
        with open(self.path("run.events.csv"), "w", encoding="utf-8") as file:
            file.write("time_s,needle,kind,region,position_x_m,position_y_m,position_z_m\n"
                       "0.01,needle,puncture,near,0,0,0\n0.9,other,crossing,far,0.05,0.03,0\n")

    def draw(self, *arguments):
        return run("client/picture", self.path("run.csv"), *arguments)

    def assert_told(self, result, text):
        self.assertNotEqual(result.returncode, 0)
        self.assertIn(text, result.stderr)
        self.assertNotIn("Traceback", result.stderr)

    def test_a_run_becomes_a_picture_beside_it(self):
        self.write_all()
        self.assert_success(self.draw())
        self.assertGreater(os.path.getsize(self.path("run.png")), 30_000)

    def test_moments_plane_needle_and_format_can_be_chosen(self):
        self.write_all()
        for name, options in (("a.svg", ["--times", "0.5"]), ("b.pdf", ["--normal", "0,0,2", "--times", "0,1,2.9"]),
                              ("c.png", ["--normal=-1,0,0", "--title", "seen along x"])):
            self.assert_success(self.draw("--out", self.path(name), "--needle", "needle", *options))
            self.assertGreater(os.path.getsize(self.path(name)), 10_000)

    def test_how_far_each_region_moved_is_printed(self):
        self.write_all()
        result = self.draw()
        self.assert_success(result)
        rows = [line.split() for line in result.stdout.splitlines()]
        self.assertEqual(rows[0], ["region", "moved", "at", "most", "(mm)", "at", "(s)"])
        self.assertEqual(rows[1:], [["near", "0.250", "1.00"], ["far", "0.750", "1.00"]])  # 1 % of 25 and 75 mm

    def test_regions_that_moved_are_named_in_the_picture(self):
        self.write_all()
        out = self.path("run.svg")
        self.assert_success(run("client/picture", self.path("run.csv"), "--out", out))
        with open(out, encoding="utf-8") as file:
            self.assertIn("Centroids moved at most: far 0.75 mm at 1.00 s, near 0.25 mm at 1.00 s", file.read())

    def test_a_run_without_tissue_becomes_a_picture_of_its_needles(self):
        self.write_all()
        with open(self.path("run.shapes"), "rb") as file:
            messages = list(msgpack.Unpacker(file))
        for message in messages:
            if message["type"] == "describe_reply":
                message.update(positions=b"", tetrahedra=b"", tetrahedron_regions=b"", regions=[])
            if message["type"] == "tissue":
                message.update(positions=b"", path_points=b"", path_sizes=b"")
        with open(self.path("run.shapes"), "wb") as file:
            file.writelines(msgpack.packb(message) for message in messages)
        result = self.draw()
        self.assert_success(result)
        self.assertEqual(result.stdout, "")
        self.assertGreater(os.path.getsize(self.path("run.png")), 20_000)

    def test_shapes_read_back_at_any_time(self):
        self.write_all()
        recorded = self.enterContext(acus.Shapes(self.path("run.shapes")))
        frame = recorded.frame(0.98)
        self.assertAlmostEqual(frame.time, 1.0)
        self.assertEqual([len(path) for path in frame.paths], [2, 1])
        np.testing.assert_allclose(frame.paths[0][-1], [0.04, 0, 0], atol=1e-7)
        np.testing.assert_allclose(frame.dents.displaced([0.04, 0, 0]), [0.041, 0, 0], atol=1e-7)
        np.testing.assert_allclose(frame.needles["other"][0][-1], [0.04, 0.03, 0])
        np.testing.assert_allclose(frame.guides["collar"][0], [-0.02, 1e-3, 0])
        np.testing.assert_allclose(recorded.needle_at("needle", 0.525)[0][-1], [0.021, 0, 0])  # between two states
        self.assertEqual(recorded.frame(99).time, recorded.tissue[-1][0])

    def test_a_file_that_ends_in_the_middle_is_drawn_as_far_as_it_goes(self):
        self.write_all()
        os.truncate(self.path("run.shapes"), os.path.getsize(self.path("run.shapes")) * 2 // 3)
        self.assert_success(self.draw())

    def test_what_cannot_be_drawn_is_told(self):
        self.write_run()
        self.assert_told(self.draw(), "acus-replay --shapes")
        for content in (b"", b"not shapes", msgpack.packb({"type": "tissue"}), msgpack.packb([1])):
            with open(self.path("run.shapes"), "wb") as file:
                file.write(content)
            self.assert_told(self.draw(), "expected shapes written by acus-replay --shapes")
        self.write_all()
        self.assert_told(self.draw("--needle", "nobody"), "its needles are needle")
        self.assert_told(self.draw("--times", "1,77"), "found 77")
        self.assert_told(self.draw("--times", "soon"), "found 'soon'")
        self.assert_told(self.draw("--normal", "0,0,0"), "not all zero")
        self.assert_told(self.draw("--out", self.path("picture.txt")), "picture.txt")


def packed(values, kind):
    return np.asarray(values).astype(kind).tobytes()


if __name__ == "__main__":
    unittest.main(verbosity=2)
