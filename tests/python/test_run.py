#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.Run: what acus-replay, a server's recording and a client's States hold of the same run is the same."""

import importlib.util
import os
import subprocess
import unittest

import numpy as np

from small_scene import PATIENCE, ROOT, InTemporaryFolder, set_up_for_class

import acus  # noqa: E402
from acus.programs import find_program  # noqa: E402

DOWN = np.array([0, 0, -1.0])


class OneRunInThreeForms(InTemporaryFolder):
    """The left needle goes 40 mm down in 100 ticks."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        made = cls.made = set_up_for_class(cls, InTemporaryFolder())
        with acus.Server(made.write_scene(), lockstep=True, options=["--recordings", made.folder]) as server:
            with server.client(timeout=PATIENCE) as client:
                start = client.needles[0].base_position
                client.record("run.acus")
                cls.states = []
                for tick in range(101):
                    client.pose("left", start + 4e-4 * tick * DOWN)
                    cls.states.append(client.step())
                client.end_recording()
                client.release("left")
                client.reset()
            rows = ["t,needle,x,y,z,qw,qx,qy,qz"]
            for t, depth in ((0, 0), (0.5, 0.04)):
                x, y, z = start + depth * DOWN
                rows.append(f"{t},left,{x!r},{y!r},{z!r},0.7071068,0,0.7071068,0")
            subprocess.run([find_program("acus-replay"), made.write("motion.csv", "\n".join(rows) + "\n"), "--lockstep",
                            "--commands", server.commands, "--states", server.states, "--out", made.path("run.csv"),
                            "--shapes", made.path("run.shapes")], check=True, timeout=PATIENCE,
                           stdout=subprocess.DEVNULL)

    def runs(self):
        return (acus.Run(self.made.path("run.csv")), acus.Run.of_states(self.states),
                self.enterContext(acus.Run(self.made.path("run.acus"))))

    def test_forces_are_arrays_with_a_row_per_tick(self):
        for run in self.runs():
            self.assertEqual(run.needles, ["left", "right"])
            left = run["left"]
            rows = len(left)
            self.assertGreaterEqual(rows, 101)
            self.assertEqual((left.depth.shape, left.base_force.shape, left.base_orientation.shape),
                             ((rows,), (rows, 3), (rows, 4)))
            self.assertEqual((left.phase[0], left.phase[-1]), ("free", "inside"))
            np.testing.assert_array_equal(left.tick, np.arange(left.tick[0], left.tick[0] + rows))
            self.assertEqual((left.tick.dtype.kind, left.stale.dtype.kind, left.phase.dtype.kind), ("i", "b", "U"))
            np.testing.assert_allclose(left.axis, np.tile(DOWN, (rows, 1)), atol=1e-6)
            np.testing.assert_allclose(left.axial_resistance, left.base_force[:, 2], rtol=1e-5, atol=1e-6)
            self.assertAlmostEqual(left.travel[-1], 0.04, delta=2e-3)
            self.assertEqual(left.touched[-1], True)

    def test_it_says_what_it_is_and_has(self):
        for run in self.runs():
            self.assertRegex(repr(run), r"<Run of .*: left \(\d+ ticks\), right \(\d+ ticks\); 2 events>")
            self.assertRegex(repr(run["left"]), r"<Track of left: \d+ ticks, \S+ to \S+ s>")
            self.assertLessEqual({"base_force", "depth", "travel", "plot"}, set(dir(run["left"])))
            with self.assertRaisesRegex(AttributeError, "'base_forces'; did you mean base_force"):
                run["left"].base_forces  # pylint: disable=pointless-statement

    @unittest.skipUnless(importlib.util.find_spec("pandas"), "SKIPPED: pandas is missing (python3-pandas)")
    def test_as_a_frame(self):
        for run in self.runs():
            frame = run.to_dataframe()
            self.assertEqual(len(frame), len(run["left"]) + len(run["right"]))
            left = frame[frame.needle == "left"]
            np.testing.assert_array_equal(left.base_force_z, run["left"].base_force[:, 2])
            np.testing.assert_array_equal(left.axial_resistance, run["left"].axial_resistance)
            self.assertEqual(left.phase.iloc[-1], "inside")
            self.assertLessEqual({"tick", "time", "depth", "base_orientation_w", "flags"}, set(frame.columns))

    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "SKIPPED: matplotlib is missing (python3-matplotlib)")
    def test_as_a_plot(self):
        from matplotlib.figure import Figure  # pylint: disable=import-outside-toplevel
        track = self.runs()[0]["left"]
        axes = track.plot(axes=Figure().subplots())
        track.plot("time", axes)
        np.testing.assert_allclose(axes.lines[0].get_xdata(), 1e3 * track.depth)
        np.testing.assert_array_equal(axes.lines[1].get_ydata(), track.axial_resistance)
        self.assertRaisesRegex(ValueError, "expected depth, travel, time", track.plot, "force")

    def test_what_a_client_kept_is_what_the_server_recorded(self):
        replayed, kept, recorded = self.runs()
        for needle in recorded:
            for name in ("time", "depth", "phase", "base_position", "base_force", "guide_force"):
                np.testing.assert_array_equal(getattr(kept[needle], name), getattr(recorded[needle], name))
        for run in (kept, recorded, replayed):
            self.assertEqual([event.kind for event in run.events], ["contact", "puncture"])
            np.testing.assert_allclose(run.events[1].position[:2], [0.003, 0.002], atol=1e-3)
            self.assertAlmostEqual(run.events[1].force, 0.5, delta=0.1)

    def test_shapes_are_beside_the_run(self):
        replayed, _, recorded = self.runs()
        self.addCleanup(replayed.close)
        for run in (replayed, recorded):
            frame = run.shapes.frame(0.4)
            self.assertEqual(frame.tissue.shape, (64, 3))
            self.assertEqual(frame.needles["left"][0].shape, (6, 3))
            self.assertEqual(frame.needles["left"][1].shape, (6, 4))
            self.assertTrue(np.all(np.diff(run.shapes.times) > 0))
            np.testing.assert_allclose(frame.guides["hole"][0], [0.003, 0.002, 0.055])
            left = run["left"]
            base = left.base_position[np.searchsorted(left.time, frame.time - 1e-9)]
            np.testing.assert_allclose(frame.needles["left"][0][0], base, atol=1e-3)
        for name in ("positions", "tetrahedra", "regions", "needles"):
            self.assertEqual(recorded.shapes.describe[name], replayed.shapes.describe[name])
        self.assertRaisesRegex(acus.RunError, "acus-replay --shapes",
                               lambda: acus.Run(self.made.path("motion.csv")).shapes)

    def test_a_recording_is_drawn_as_it_is(self):
        out = self.path("run.png")
        done = subprocess.run([os.path.join(ROOT, "client", "picture"), self.made.path("run.acus"), "--out", out],
                              capture_output=True, text=True, timeout=4 * PATIENCE, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater(os.path.getsize(out), 30_000)

    def test_no_result_is_written_over_the_recording_or_another_result(self):
        recording, before = self.made.path("run.acus"), os.path.getsize(self.made.path("run.acus"))
        same = self.path("same")
        for arguments in (["--shapes", recording], ["--csv", same, "--shapes", same]):
            done = subprocess.run([find_program("acus-export"), recording, *arguments], capture_output=True, text=True,
                                  timeout=PATIENCE, check=False)
            self.assertEqual(done.returncode, 3)
            self.assertIn("give", done.stderr)
        self.assertEqual(os.path.getsize(recording), before)
        self.assertFalse(os.path.exists(same))

    def test_a_run_that_began_anew_has_epochs(self):
        with acus.Server(self.made.path("small.yaml"), lockstep=True, options=["--recordings", self.folder]) as server:
            with server.client(timeout=PATIENCE) as client:
                client.record("twice.acus")
                states = client.trace(20)
                client.reset()
                states += client.trace(30)
                client.end_recording()
        with acus.Run(self.path("twice.acus")) as recorded:
            for run in (recorded, acus.Run.of_states(states)):
                self.assertEqual((run.epochs, len(run["left"])), ([0, 1], 50))
                self.assertEqual([len(run.of_epoch(epoch)["left"]) for epoch in run.epochs], [20, 30])
            with recorded.of_epoch(0) as first:
                self.assertEqual([run.shapes.times[-1] for run in (first, recorded)], [0.07, 0.14])
            self.assertTrue(np.all(np.diff(recorded.shapes.times) > 0))

    def test_what_is_not_there_is_named(self):
        run = self.runs()[0]
        self.assertRaisesRegex(acus.RunError, "its needles are left, right", lambda: run["middle"])
        self.assertRaisesRegex(acus.RunError, "no column 'colour'", run["left"].column, "colour")
        self.assertRaises(AttributeError, getattr, run["left"], "colour")


class Broken(InTemporaryFolder):
    def test_files_that_are_no_run_are_told(self):
        for text, expected in (("", "no rows"), ("needle,depth_m\n", "no rows"), ("a\n1\n", "no column 'needle'"),
                               ("needle,depth_m\nn,1\nn\n", ":3: expected 2 cells, found 1"),
                               ("needle,depth_m\nn,deep\n", "column 'depth_m'"), ("needle\nn\n", "no column 'depth'")):
            run = acus.Run(self.write("run.csv", text))
            with self.assertRaisesRegex(acus.RunError, expected):
                run["n"].depth  # pylint: disable=expression-not-assigned
        self.assertRaisesRegex(acus.RunError, "No such file", lambda: acus.Run(self.path("none.csv")).needles)
        with open(self.path("bad.acus"), "wb") as file:
            file.write(b"\x28\xb5\x2f\xfd no recording")
        with acus.Run(self.path("bad.acus")) as run:
            self.assertRaisesRegex(acus.RunError, "acus-export ended", lambda: run.needles)


if __name__ == "__main__":
    unittest.main()
