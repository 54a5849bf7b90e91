#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.study: how needles move in a case, and what is told of it."""

import dataclasses
import math
import subprocess
import unittest

import numpy as np

from of_studies import PUSH, STIFFNESS, OfStudies
from small_scene import SCENE

import acus  # noqa: E402
from acus import engine, rotation, study  # noqa: E402


# ---- Motions ----


class Motions(OfStudies):
    def world(self, motion, scene=None):
        model = engine.load(scene or self.scene)
        return study.World(model, bodies=motion.bodies(model))

    def test_an_insertion_goes_through_its_entry_in_its_direction(self):
        motion = acus.Insertion(depth=0.02, entry=(0.01, 0.0, 0.05), direction=(0.3, 0.1, -1), tilt=0.2, azimuth=1.0, turn=0.5)
        world = self.world(motion)
        needle = world.needle()
        tip = world.state.needle_positions("left")[-1]
        np.testing.assert_allclose(tip + 5e-3 * needle.axis, motion.entry, atol=1e-12)
        angle = math.acos(needle.axis @ rotation.unit(motion.direction))
        self.assertAlmostEqual(angle, 0.2, 9)
        motion(world)
        np.testing.assert_allclose(world.report["left"].base_position, needle.base_position + 0.025 * needle.axis, atol=1e-5)

    def test_without_anything_it_begins_where_the_scene_has_it(self):
        needle = engine.load(self.scene).needles[0]
        self.assertEqual(PUSH.bodies(engine.load(self.scene)), {})
        position, orientation = dataclasses.replace(PUSH, tilt=1e-15).bodies(engine.load(self.scene))["left"]
        np.testing.assert_allclose(position, needle.base_position, atol=1e-12)
        np.testing.assert_allclose(orientation, needle.base_orientation, atol=1e-12)
        tilted = dataclasses.replace(PUSH, tilt=0.3).bodies(engine.load(self.scene))["left"]
        tip = tilted[0] + needle.length * rotation.axis_of(tilted[1])
        np.testing.assert_allclose(tip, needle.tip_position, atol=1e-12)  # about the tip

    def test_its_guides_go_with_it(self):
        world = self.world(acus.Insertion(depth=0.01, entry=(0.02, 0.01, 0.05), tilt=0.1))
        needle, guide = world.needle(), world.guides[0]
        across = guide.position - needle.base_position
        self.assertLess(np.linalg.norm(across - (across @ needle.axis) * needle.axis), 1e-9)
        np.testing.assert_allclose(rotation.axis_of(guide.orientation), needle.axis, atol=1e-6)

    def test_it_rests_and_comes_back(self):
        motion = acus.Insertion(depth=0.03, speed=0.1, hold=0.05, pull_back=True, spin_rate=2.0)
        world = self.world(motion)
        motion(world)
        travel = study.Result(world).track.travel
        self.assertEqual(len(travel), 60 + 1 + 10 + 60 + 1)
        self.assertAlmostEqual(max(travel), 0.03, 3)  # from the first tick
        self.assertAlmostEqual(travel[-1], 0, 3)
        self.assertAlmostEqual(study.Result(world).track.spin[-1], 2.0 * 0.3, 6)

    def test_a_component_can_be_a_parameter(self):
        made = self.study({"motion.entry[0]": [0.0, 0.01]}, motion=acus.Insertion(depth=0.01, entry=(0, 0, 0.05)))
        self.assertEqual(made.definition.motion_of(1).entry, (0.01, 0, 0.05))
        made = self.run_study({"motion.entry[0]": [0.0]})
        self.assertIn("no such component", made.rows[0]["error"])

    def test_a_trajectory_is_as_acus_replay_drives_it(self):
        path = self.write("small.yaml", SCENE.format(name="small"))
        rows = [f"{t:.3f},{name},{x},{y},{0.16 - 0.1 * t - 0.02 * t * t},0.7071068,0,0.7071068,0,{2 * t}"
                for t in np.arange(0, 0.35, 0.013) for name, x, y in (("left", 0.003, 0.002), ("right", 0.03, 0.0))]
        motion = self.write("motion.csv", "# a comment\n" + "t,needle,x,y,z,qw,qx,qy,qz,spin\n" + "\n".join(rows) + "\n")
        made = acus.Study(path, motion, {STIFFNESS: [1e4]}, {"run": lambda result: None}, folder=self.path("study"))
        result = made.case(0)
        with acus.Server(made.scene(0), lockstep=True) as server:
            done = subprocess.run([acus.programs.find_program("acus-replay"), motion, "--lockstep", "--commands", server.commands,
                                   "--states", server.states, "--out", self.path("run.csv")],
                                  capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        with acus.Run(self.path("run.csv")) as run:
            for needle in ("left", "right"):
                theirs, ours = run[needle], result.run[needle]
                begin = len(ours) - len(theirs)
                for name in ("base_position", "base_force", "tip_position", "spin"):
                    np.testing.assert_allclose(getattr(ours, name)[begin:], getattr(theirs, name), atol=1e-12, err_msg=name)

    def test_a_study_of_trajectories(self):
        header = "t,needle,x,y,z,qw,qx,qy,qz\n0,left,0.003,0.002,0.16,0.7071068,0,0.7071068,0\n"
        paths = [self.write(f"{depth}.csv", header + f"0.1,left,0.003,0.002,{0.16 - depth},0.7071068,0,0.7071068,0\n")
                 for depth in (0.001, 0.005)]
        made = self.run_study({"motion.path": paths}, motion=paths[0], outputs=["tip"])
        self.assertAlmostEqual(made.rows[0]["tip.z"] - made.rows[1]["tip.z"], 0.004, 3)

    def test_a_trajectory_can_be_shifted(self):
        motion = self.write("motion.csv", "t,needle,x,y,z,qw,qx,qy,qz\n0,left,0.003,0.002,0.16,0.7071068,0,0.7071068,0\n"
                                          "0.1,left,0.003,0.002,0.14,0.7071068,0,0.7071068,0\n")
        made = self.run_study({"motion.shift": [(0, 0, 0), (0.01, 0, 0)]}, motion=motion, outputs=["tip"])
        self.assertAlmostEqual(made.rows[1]["tip.x"] - made.rows[0]["tip.x"], 0.01, 3)

    def test_trajectories_that_are_none(self):
        for text, what in (("", "no column 't'"), ("t,needle,x,y,z,qw,qx,qy,qz\n", "no rows"),
                           ("t,needle,x,y,z,qw,qx,qy,qz\n0,a,0,0,0,1,0,0\n", "9 cells"),
                           ("t,needle,x,y,z,qw,qx,qy,qz\n0,a,0,0,0,2,0,0,0\n", "unit quaternion"),
                           ("t,needle,x,y,z,qw,qx,qy,qz\n0,a,0,0,0,1,0,0,0\n0,a,0,0,0,1,0,0,0\n", "do not rise"),
                           ("t,needle,x,y,z,qw,qx,qy,qz\n0,a,0,nan,0,1,0,0,0\n", "not finite"),
                           ("t,needle,x,y,z,qw,qx,qy,qz\n0,a,0,b,0,1,0,0,0\n", "could not convert")):
            self.assertRaisesRegex(acus.StudyError, what, study.Trajectory, self.write("wrong.csv", text))
        other = self.write("other.csv", "t,needle,x,y,z,qw,qx,qy,qz\n0,middle,0,0,0,1,0,0,0\n")
        self.assertIn("no needle or guide 'middle'", self.run_study({STIFFNESS: [5e3]}, motion=other).rows[0]["error"])


# ---- Outputs ----


class Outputs(OfStudies):
    def result(self, motion=PUSH):
        return self.study({STIFFNESS: [5e3]}, motion=motion).case(0)

    def test_what_they_tell_is_what_the_run_has(self):
        result = self.result(acus.Insertion(depth=0.04, speed=0.1))
        track, outputs = result.track, study.OUTPUTS
        self.assertEqual(outputs["peak_force"](result), track.axial_resistance.max())
        self.assertEqual(outputs["depth"](result), track.depth[-1])
        np.testing.assert_array_equal(outputs["tip"](result), track.tip_position[-1])
        self.assertAlmostEqual(outputs["puncture_force"](result), 0.5, 2)
        kinds = {event.kind: event.tick for event in result.run.events}
        self.assertAlmostEqual(outputs["puncture_travel"](result), (kinds["puncture"] - kinds["contact"]) * 5e-4, 9)
        length = outputs["path_length"](result)
        self.assertTrue(0 < track.depth[-1] - length < 4e-3, (length, track.depth[-1]))  # 3.3 mm, on this coarse mesh
        self.assertAlmostEqual(outputs["swept_volume"](result), length * math.pi / 4 * 1e-6, 12)
        self.assertLess(outputs["deflection"](result), 1e-3)
        power = np.sum(track.base_force * np.gradient(track.base_position, axis=0), axis=1)
        self.assertAlmostEqual(outputs["work"](result) / -power.sum(), 1, 1)  # 0.99: the ends count whole there
        self.assertGreater(outputs["work"](result), 0)

    def test_without_a_puncture(self):
        result = self.result(acus.Insertion(depth=1e-3))
        self.assertTrue(math.isnan(study.OUTPUTS["puncture_force"](result)) and math.isnan(study.OUTPUTS["puncture_travel"](result)))
        self.assertEqual((study.OUTPUTS["depth"](result), study.OUTPUTS["path_length"](result)), (0, 0))

    def test_of_another_needle(self):
        made = self.run_study({STIFFNESS: [5e3]}, outputs=["tip", "tip[right]", "peak_force[right]"])
        self.assertAlmostEqual(made.rows[0]["tip[right].x"], 0.03, 6)
        self.assertAlmostEqual(made.rows[0]["peak_force[right]"], 0, 9)
        self.assertIn("no needle 'middle'", self.run_study({STIFFNESS: [5e3]}, outputs=["tip[middle]"]).rows[0]["error"])

    def test_a_target_moves_with_the_tissue(self):
        result = self.result()
        node = int(np.argmin(np.linalg.norm(result.model.rest_positions - [0.0, 0.0, 0.05], axis=1)))
        rest, now = result.model.rest_positions[node], result.state.tissue_positions[node]
        self.assertGreater(np.linalg.norm(now - rest), 1e-4)
        tip = result.track.tip_position[-1]
        self.assertAlmostEqual(study.Distance(rest)(result), np.linalg.norm(tip - now), 9)
        self.assertAlmostEqual(study.Distance(rest, moves=False)(result), np.linalg.norm(tip - rest), 12)
        self.assertRaisesRegex(acus.StudyError, "not inside the tissue", study.Distance((1, 1, 1)), result)


if __name__ == "__main__":
    unittest.main()
