#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.plan: where a needle should go in."""

import contextlib
import dataclasses
import io
import math
import os
import subprocess
import unittest

import numpy as np

from small_scene import InTemporaryFolder

import acus  # noqa: E402
from acus import engine, rotation, study  # noqa: E402
from acus.env.scenes import steering  # noqa: E402
from acus.plan import approach, candidates, entries, planner, question, shapes, tissue, uncertain  # noqa: E402
from acus.study.case import Models  # noqa: E402

TOP = 0.06  # m, z of the surface
TARGET = (0.0, 0.0, 0.0)
ENTRIES = {"cylinder": {"from": [0, 0, 0.05], "to": [0, 0, 0.07], "radius": 0.01}}
OBSTACLE = {"sphere": {"center": [0.0, 0.0, 0.03], "radius": 0.004}}
MODELS = Models()


def small():
    """The bevel needle above a gel of acus.env, with a region in it, and fewer nodes."""
    scene = steering()
    scene["tissue.mesh.box.cells"] = [4, 4, 6]
    core = {**scene["tissue.regions[0]"], "name": "core", "sphere": {"center": [0.02, 0.02, -0.03], "radius": 0.025}}
    scene.add("tissue.regions", core)
    return scene


@unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
class OfPlans(InTemporaryFolder):
    def setUp(self):
        super().setUp()
        self.scene = small()
        self.model = MODELS.load(self.scene)

    def world(self, motion):
        world = study.World(self.model, bodies=motion.bodies(self.model))
        motion(world)
        return world

    def plan(self, *arguments, **settings):
        return acus.plan(self.scene, *arguments, **{"folder": self.path("plans"), "progress": False, "cases": 60, "samples": 6, "workers": 0,
                                                    "speed": 0.1, **settings})


# ---- Places and tissue ----


class Places(OfPlans):
    def distances(self, given, points):
        return shapes.Place("avoid", given).distances(self.model, points)

    def test_shapes_have_the_distances_of_their_closed_forms(self):
        np.testing.assert_allclose(self.distances({"sphere": {"center": [1, 0, 0], "radius": 2}}, [[1, 0, 0], [4, 0, 0], [1, 3, 0]]), [-2, 1, 1])
        box = {"box": {"min": [0, 0, 0], "max": [1, 2, 3]}}
        np.testing.assert_allclose(self.distances(box, [[0.5, 1, 1.5], [2, 1, 1], [2, 3, 1], [0.9, 1, 1]]), [-0.5, 1, math.sqrt(2), -0.1])
        np.testing.assert_allclose(self.distances({"box": {"max": [math.inf, math.inf, 0]}}, [[5, 5, 1], [5, 5, -2]]), [1, -2])
        np.testing.assert_allclose(self.distances({"half_space": {"point": [0, 0, 1], "normal": [0, 0, 2]}}, [[9, 9, 3], [0, 0, 0]]), [2, -1])
        rod = {"cylinder": {"from": [0, 0, 0], "to": [0, 0, 2], "radius": 1}}
        np.testing.assert_allclose(self.distances(rod, [[0, 0, 1], [3, 0, 1], [0, 0, 5], [4, 0, 6]]), [-1, 2, 3, 5])

    def test_of_several_the_common_part_counts(self):
        both = {"sphere": {"center": [0, 0, 0], "radius": 1}, "half_space": {"point": [0, 0, 0]}}
        np.testing.assert_allclose(self.distances(both, [[0, 0, -0.5], [0, 0, 0.25]]), [-0.5, 0.25])

    def test_a_region_has_the_distances_to_its_triangles(self):
        nodes = self.model.rest_positions
        core = tissue.tetrahedra_of(self.model, "core")
        triangles = nodes[tissue.boundary_of(core)]
        points = np.random.default_rng(3).uniform(-0.05, 0.05, (40, 3))
        u, v = np.meshgrid(np.linspace(0, 1, 60), np.linspace(0, 1, 60))
        u, v = u[u + v <= 1], v[u + v <= 1]
        a, b, c = np.moveaxis(triangles, 1, 0)
        dense = (a[:, None] + u[:, None] * (b - a)[:, None] + v[:, None] * (c - a)[:, None]).reshape(-1, 3)
        for point, distance in zip(points, self.distances("core", points)):
            brute = np.min(np.linalg.norm(dense - point, axis=1))
            self.assertAlmostEqual(abs(distance), brute, delta=1e-3)
            self.assertEqual(distance < 0, tissue.Tetrahedra(nodes[core]).find(point) is not None)

    def test_a_region_borders_on_the_rest_and_its_surface_is_closed(self):
        for region in self.model.regions:
            a, b, c = np.moveaxis(self.model.rest_positions[tissue.boundary_of(tissue.tetrahedra_of(self.model, region))], 1, 0)
            np.testing.assert_allclose(np.cross(b - a, c - a).sum(axis=0), 0, atol=1e-12)
        surface = tissue.Surface(self.model)
        self.assertAlmostEqual(surface.areas.sum(), 2 * 0.08 * 0.08 + 4 * 0.08 * 0.12, 9)
        points, places = surface.points(500)
        np.testing.assert_allclose(np.abs(points / [0.04, 0.04, 0.06]).max(axis=1), 1, atol=1e-9)
        np.testing.assert_allclose(np.sum(surface.normals[places] * points, axis=1) > 0, True)

    def test_a_line_meets_the_surface_from_outside(self):
        surface = tissue.Surface(self.model)
        point, place = surface.hit(np.array([0.01, 0.02, 0.16]), np.array([0.1, 0, -1]))
        np.testing.assert_allclose(point, [0.02, 0.02, TOP], atol=1e-9)
        np.testing.assert_allclose(surface.normals[place], [0, 0, 1], atol=1e-9)
        self.assertIsNone(surface.hit(np.array([1.0, 0, 0]), np.array([0.0, 0, -1])))

    def test_points_of_deformed_tissue_are_found_at_rest(self):
        rest = self.model.rest_positions
        turn = rotation.rotation_about([1, 2, 3], 0.3)
        stretched = rotation.rotate(turn, rest * [1.1, 0.95, 1.02]) + [0.01, 0, 0]
        points = np.random.default_rng(5).uniform(-1, 1, (30, 3)) * [0.04, 0.04, 0.06]
        moved = rotation.rotate(turn, points * [1.1, 0.95, 1.02]) + [0.01, 0, 0]
        found = tissue.Deformed(self.model, stretched).at_rest(np.concatenate([moved, [[1, 1, 1]]]))
        np.testing.assert_allclose(found[:-1], points, atol=1e-12)
        self.assertTrue(np.all(np.isnan(found[-1])))

    def test_errors_name_the_field_and_the_remedy(self):
        for given, text in (("bone", "avoid\\[bone\\]: the tissue has no region 'bone'; it has gel, core"),
                            ({"x": {"ball": {}}}, "no shape 'ball'; there are sphere"), (5, "expected shapes or names"), ([5], "such as"),
                            ({"sphere": {"center": [0, 0, 0]}}, "avoid\\[shape 1\\].sphere: expected center, radius"),
                            ({"sphere": {"center": [0, 0, 0], "radius": -1}}, "radius: expected a number above 0"),
                            ({"box": {"min": [1, 1, 1], "max": [0, 2, 2]}}, "min below max"),
                            ({"sphere": {"center": [0, 0, 0.005], "radius": 0.01}}, "the target .* lies in it")):
            with self.assertRaisesRegex(acus.PlanError, text):
                self.plan(TARGET, ENTRIES, given)
        for settings, text in (({"radius": 0}, "radius"), ({"cases": 3}, "cases: expected a whole number, at least 20"), ({"tilt": 2}, "tilt"),
                               ({"uncertain": {"softness": (1, 2)}}, "uncertain: .*stiffness, friction, bevel"), ({"minutes": -1}, "minutes"),
                               ({"entry_region": {"sphere": {"center": [0, 0, 0], "radius": 0.01}}}, "no part of the tissue's surface"),
                               ({"entry_region": {"box": {"max": [9, 9, -0.05]}}}, "from nowhere in it the needle"),
                               ({"needle": "other"}, "needle: .* no needle 'other'"), ({"samples": 40}, "cases: 60 insertions are too few; .* at least 100"),
                               ({"minutes": "x"}, "minutes: expected a finite number"), ({"seed": -1}, "seed: expected a whole number"),
                               ({"seed": 1.5}, "seed"), ({"uncertain": 5}, "uncertain: expected {name: range}"), ({"folder": ""}, "folder: expected a path"),
                               ({"uncertain": {"stiffness": (-1, 1)}}, "uncertain: stiffness: expected factors above 0"), ({"speed": 100.0}, "speed: expected .* to"),
                               ({"avoid": {"x": {"sphere": {"center": [5, 5, 5], "radius": 0.01}}}}, "avoid\\[x\\]: it lies nowhere near the tissue; .* m in the world")):
            with self.assertRaisesRegex(acus.AcusError, text):
                self.plan(TARGET, **settings)
        with self.assertRaisesRegex(acus.PlanError, "target: .* is not inside the tissue"):
            self.plan((0, 0, 1))
        with self.assertRaisesRegex(acus.PlanError, "target: the tissue has no region 'bone'"):
            self.plan("bone")
        for scene in (None, {"name": "x"}):
            with self.assertRaisesRegex(acus.PlanError, "scene: expected a Scene"):
                acus.plan(scene, TARGET)


# ---- Insertions ----


class Insertions(OfPlans):
    def test_a_flip_is_half_a_turn_at_rest(self):
        motion = acus.Insertion(depth=0.03, speed=0.1, flips=(0.01, 0.02))
        world = study.World(self.model)
        advances, spins = np.transpose(motion.places(world))
        self.assertAlmostEqual(advances[-1], 0.03)
        self.assertAlmostEqual(spins[-1], 2 * math.pi)
        self.assertTrue(np.all(np.diff(advances) >= 0) and np.all(np.diff(spins) >= 0))
        turning = np.diff(spins, prepend=0) > 0
        for at, angle in ((0.01, math.pi), (0.02, 2 * math.pi)):
            np.testing.assert_allclose(advances[turning & (spins <= angle + 1e-9) & (spins > angle - math.pi + 1e-9)], at, atol=1e-3 + 1e-9)
        plain = acus.Insertion(depth=0.03, speed=0.1).places(world)
        self.assertEqual([advance for advance, _ in plain], list(dict.fromkeys(advances)))
        for wrong in ((0.02, 0.01), (-0.01,), "ab", 5, (math.nan,)):
            with self.assertRaisesRegex(acus.StudyError, "motion.flips: expected rising numbers"):
                acus.Insertion(depth=0.03, flips=wrong)

    def test_a_branch_has_the_bits_of_a_run_of_its_own(self):
        begin = approach.Approach(0.08, 0.1, entry=(0.001, 0, TOP), direction=(0, 0, -1), target=TARGET, tries=(0.02, 0.04))
        world = self.world(begin)
        ends = world.notes["ends"]
        self.assertEqual([end.flip for end in ends], [None, 0.02, 0.04])
        self.assertEqual(len({end.world.state.hash for end in ends}), 3)
        for end in ends[1:]:
            alone = self.world(dataclasses.replace(begin, flips=(end.flip,), tries=()))
            self.assertEqual(alone.state.hash, end.world.state.hash)
            self.assertEqual(len(alone.reports), len(end.world.reports))

    def test_an_approach_ends_where_the_tip_passes_the_target_that_has_moved(self):
        world = self.world(approach.Approach(0.1, 0.05, entry=(0, 0, TOP), direction=(0, 0, -1), spin_rate=12.0, target=TARGET))
        target = approach.TissuePoint(self.model, TARGET, "target")
        np.testing.assert_allclose(target.at(self.model.start()), TARGET, atol=1e-12)
        tip = world.state.needle_positions("needle")[-1]
        self.assertLess(abs((target.at(world.state) - tip)[2]), 1e-3)
        judged = approach.Judged(TARGET, (("ball", shapes.Place("avoid", OBSTACLE)),))(study.Result(world))
        np.testing.assert_allclose(judged["miss"], target.at(world.state) - tip)
        self.assertAlmostEqual(judged["force"], acus.study.OUTPUTS["peak_force"](study.Result(world)), 9)
        self.assertLess(judged["clearance"]["ball"], -2e-3)  # straight through it

    def test_a_path_that_turns_with_its_needle_meets_the_target(self):
        problem = self.problem()
        along = np.linspace(0, 0.06, 61)
        path = np.stack([along**2 / (2 * 0.2), 0 * along, TOP - along], axis=1)  # an arc towards +x
        end = candidates.Outcome(np.array(TARGET) - path[-1], 0.5, path, path[:5], {}, 0.06)
        begin = candidates.Candidate(np.array([0, 0, TOP]), np.array([0, 0, -1.0]), end=end)
        for turn in (0.0, 1.0, math.pi):
            made = candidates.follow(problem, begin, turn, np.array([0.004, -0.003, TOP]))
            missed = made.end.shaft[-1] - TARGET
            self.assertLess(np.linalg.norm(missed - (missed @ made.direction) * made.direction), 2e-4)  # in depth it is the way that it was
            np.testing.assert_allclose(made.end.shaft[0], made.entry, atol=1e-12)
            self.assertAlmostEqual(made.turn, turn)
            shifted = candidates.follow(dataclasses.replace(problem, tilt=0.0), begin, turn)
            np.testing.assert_allclose(shifted.end.shaft[-1], TARGET, atol=1e-9)
            np.testing.assert_allclose(shifted.direction, begin.direction)

    def problem(self):
        return candidates.Problem(self.model, tissue.Surface(self.model), np.array(TARGET), (), None, np.array([0, 0, -1.0]), 0.6, 2e-3, 0.15, 4e-4)

    def test_factors_change_what_they_name(self):
        values = {"stiffness": 2.0, "friction": 0.5, "bevel": 3.0}
        uncertain.Factors()(self.scene, values)
        for region in range(2):
            self.assertEqual(self.scene[f"tissue.regions[{region}].material.young_modulus"], 60e3)
            self.assertEqual(self.scene[f"tissue.regions[{region}].interaction.friction_static"], 0.175)
        self.assertAlmostEqual(self.scene["needles[0].cutting_direction[1]"], 0.3)
        self.assertEqual(self.scene["needles[0].cutting_direction[0]"], 1)
        self.scene.check()
        arc = acus.Scene.read(acus.find_scene("steering_arc"))
        uncertain.Factors()(arc, {"bevel": 1.2})
        self.assertEqual(arc["needles[0].point_offset"], 1.2)
        arc.check()

    def test_the_interval_of_a_share_is_wilsons(self):
        np.testing.assert_allclose(uncertain.wilson(8, 10), (0.4902, 0.9433), atol=1e-4)
        self.assertEqual(uncertain.wilson(0, 10)[0], 0)
        for count in range(1, 200):
            self.assertEqual((uncertain.wilson(0, count)[0], uncertain.wilson(count, count)[1]), (0, 1))


# ---- Corridors ----


class Corridors(OfPlans):
    """A plate that no force punctures lies above the target, but for a strip of 15 mm; half of the strip is to be avoided."""

    TARGET = (0.02, 0.0, -0.02)

    def setUp(self):
        super().setUp()
        plate = {"name": "plate", "box": {"min": [-math.inf, -math.inf, 0.0], "max": [0.02, math.inf, 0.03]},
                 "interaction": {"puncture_force": math.inf}}
        self.scene.add("tissue.regions", plate)
        self.model = MODELS.load(self.scene)

    def problem(self, avoid=None, entry_region=None):
        return question.problem_of(self.scene, self.model, self.model.needles[0], self.TARGET, entry_region, avoid, 0.6, 2e-3)

    def test_ways_through_what_cannot_be_passed_are_left_out(self):
        for avoid in (None, {"half": {"box": {"min": [-math.inf, -math.inf, 0.0], "max": [math.inf, 0.0, math.inf]}}}):
            problem = self.problem(avoid)
            found = entries.entries_of(problem, 6, 0)
            self.assertGreaterEqual(len(found), 3)
            for entry in found:
                self.assertGreater(problem.corridor(entry), 0)
                self.assertGreater(entry[0], 0.02)
                if avoid:
                    self.assertGreater(entry[1], 0)
            self.assertLess(problem.corridor(np.array([0.0, 0.0, TOP])), 0)

    def test_the_widest_ways_count_as_long_as_there_are_enough(self):
        points, free = np.arange(30.0).reshape(10, 3), np.array([-1, 0.5, 1.5, 3, 5, 6, 7, 8, -2, 9]) * 1e-3
        self.assertEqual(len(entries.widest(points, free, 5)), 5)
        self.assertEqual(len(entries.widest(points, free, 6)), 6)
        self.assertEqual(len(entries.widest(points, free, 20)), 8)
        self.assertEqual(len(entries.widest(points, -np.abs(free), 5)), 10)

    def test_where_no_way_is_free_all_stay(self):
        problem = self.problem(entry_region={"cylinder": {"from": [0, 0, 0.05], "to": [0, 0, 0.07], "radius": 0.01}})
        self.assertTrue(len(entries.entries_of(problem, 4, 0)))

    def test_the_target_and_what_is_to_be_avoided_stand_once_among_the_walls(self):
        names = [name for name, _ in self.problem(["plate"]).walls]
        self.assertEqual(names, ["plate"])
        self.assertEqual([name for name, _ in self.problem().walls], ["plate"])


# ---- Plans ----


class Planned(OfPlans):
    def test_a_needle_bends_around_what_it_cannot_pass_straight(self):
        plans = self.plan(TARGET, ENTRIES, {"ball": OBSTACLE}, cases=80, uncertain={"stiffness": (0.9, 1.1), "bevel": (0.97, 1.03)})
        best = plans[0]
        self.assertGreater(best.probability, 0.8, str(plans))
        self.assertGreater(best.clearance["ball"], 0)
        self.assertFalse(best.motion.spin_rate)
        for plan in plans:
            self.assertLessEqual(plan.interval[0], plan.probability)
            self.assertLessEqual(plan.probability, min(plan.hit, plan.clear) + 1e-12)
            self.assertLessEqual(np.linalg.norm(np.array(plan.motion.entry)[:2]), 0.01 + 1e-6)
        self.assertEqual([plan.probability for plan in plans], sorted((plan.probability for plan in plans), reverse=True))
        plans.draw(self.path("plan.png"))
        with open(self.path("plan.png"), "rb") as file:
            self.assertEqual(file.read(4), b"\x89PNG")
        self.assertIn("to ball mm", str(plans))
        self.check_what_it_writes(best)

    def check_what_it_writes(self, plan):
        """The server with the plan's scene and the replay with its trajectory end where the plan does."""
        result = plan.run(self.path("plan.acus"))
        self.assertGreater(os.path.getsize(self.path("plan.acus")), 1000)
        np.testing.assert_allclose(plan.nominal.miss, approach.TissuePoint(self.model, TARGET, "target").at(result.state) - result.track.tip_position[-1],
                                   atol=1e-12)
        self.write("plan.csv", "t,needle,x,y,z,qw,qx,qy,qz,spin\n0,needle,0,0,0,1,0,0,0,0\n")
        self.assertRaisesRegex(acus.PlanError, "plan.csv: something else stands there", plan.write, self.path("plan"))
        self.assertFalse(os.path.exists(self.path("plan.yaml")))
        os.remove(self.path("plan.csv"))
        for _ in range(2):
            scene, trajectory = plan.write(self.path("plan"))
        with acus.Server(scene, lockstep=True) as server:
            replay = os.path.join(os.path.dirname(acus.find_server()), "acus-replay")
            subprocess.run([replay, trajectory, "--lockstep", "--commands", server.commands, "--states", server.states, "--out", self.path("run.csv")],
                           check=True, capture_output=True, timeout=60)
        with acus.Run(self.path("run.csv")) as run:
            np.testing.assert_allclose(run["needle"].tip_position[-1], result.track.tip_position[-1], atol=5e-5)

    def test_the_same_call_gives_the_same_plans_from_its_folder_and_on_any_number_of_workers(self):
        first = self.plan("core", None, cases=20, samples=2)
        told = io.StringIO()
        with contextlib.redirect_stderr(told):
            again = self.plan("core", None, cases=20, samples=2, workers=1, progress=True)
        self.assertIn("are there already", told.getvalue())
        other = self.plan("core", None, cases=20, samples=2, workers=2, folder=self.path("other"))
        for plans in (again, other):
            self.assertEqual(str(plans), str(first))
            self.assertEqual([plan.motion for plan in plans], [plan.motion for plan in first])
        np.testing.assert_allclose(first.target, tissue.centroid_of(self.model, "core"))

    def test_a_given_direction_stays_and_the_entry_moves(self):
        plans = self.plan(TARGET, ENTRIES, tilt=0, cases=60, uncertain={})
        axis = self.model.needles[0].axis
        for plan in plans:
            np.testing.assert_allclose(plan.motion.direction, axis, atol=1e-9)
            self.assertEqual(len(plan.outcomes), 1)
        self.assertLess(plans[0].miss, 1e-3, str(plans))
        self.assertEqual(plans[0].probability, 1)

    def test_a_straight_needle_is_planned_without_turns(self):
        self.scene["needles[0].cutting_direction"] = [1, 0, 0]
        plans = self.plan(TARGET, ENTRIES, cases=30, samples=3)
        self.assertLess(plans[0].miss, 1e-3, str(plans))
        self.assertTrue(all(plan.motion.turn == 0 and not plan.motion.flips and not plan.motion.spin_rate for plan in plans))

    def test_what_slips_or_does_not_enter_is_no_success(self):
        self.scene["tissue.regions[gel].interaction.puncture_force"] = math.inf
        with self.assertRaisesRegex(acus.PlanError, "the tip of 'needle' enters the tissue nowhere; the largest force was .* puncture_force"):
            self.plan(TARGET, ENTRIES, cases=20)
        straight = np.stack([np.zeros(30), np.zeros(30), TOP - np.linspace(0, 0.06, 30)], axis=1)
        outcome = candidates.Outcome(np.zeros(3), 0.1, straight, straight, {}, 0.06)
        self.assertTrue(outcome.enters(np.array([0, 0, TOP]), (0, 0, -1.0)))
        self.assertFalse(outcome.enters(np.array([0.01, 0, TOP]), (0, 0, -1.0)))
        self.assertFalse(dataclasses.replace(outcome, cut=np.zeros((0, 3))).enters(np.array([0, 0, TOP]), (0, 0, -1.0)))
        problem = Insertions.problem(self)
        for entry, even in (([0, 0, TOP], True), ([0.0385, 0, TOP], False), ([0, -0.0399, 0.02], False)):
            self.assertEqual(problem.is_even(np.array(entry), np.array([0, 0, -1.0])), even, entry)

    def test_no_more_is_simulated_than_was_asked_for(self):
        for samples in (1, 8, 9):
            question = self.question(cases=60, samples=samples)
            self.assertEqual((len(question.draws), len(question.first)), (samples + 1, 9 if samples == 9 else 0))
        self.assertEqual(self.question(cases=20, samples=30, uncertain={}).samples_of_plan, 1)
        self.assertLessEqual(self.plan(TARGET, ENTRIES, cases=20, samples=8, speed=0.2).cases, 20)

    def test_minutes_bound_what_is_simulated(self):
        plans = self.plan(TARGET, ENTRIES, minutes=0.03, samples=1, uncertain={}, speed=0.2)
        self.assertGreaterEqual(plans.cases, 10)
        self.assertEqual(str(self.plan(TARGET, ENTRIES, minutes=0.03, samples=1, uncertain={}, speed=0.2)), str(plans))  # by the time noted

    def question(self, **settings):
        given = {"radius": 2e-3, "uncertain": None, "tilt": 0.6, "speed": 0.1, "needle": None, "cases": 60, "minutes": None, "seed": 0, "folder": None,
                 "on": None, "workers": 0, "progress": False, **settings}
        return planner.Question(self.scene, TARGET, ENTRIES, None, given.pop("samples"), **given)

    def test_with_a_given_direction_the_coarse_search_looks_to_all_sides(self):
        asked = []
        made = planner.Planner(self.question(tilt=0, cases=400, samples=30))
        made._approach = lambda label, candidates, branch=False: asked.extend(candidates) or []
        with self.assertRaises(acus.PlanError):
            made.run()
        turns = sorted(round(math.degrees(each.turn)) for each in asked if not each.spin_rate)
        self.assertEqual(turns, list(range(0, 360, 45)))
        self.assertEqual(sum(bool(each.spin_rate) for each in asked), 1)

    def test_samples_that_all_fail_say_why(self):
        plans = self.plan(TARGET, ENTRIES, cases=20, samples=2, uncertain={"tissue.regions[0].material.poisson_ratio": (0.6, 0.9)}, speed=0.2)
        self.assertRegex(str(plans), "no plan succeeds in any sample; all samples failed: .*poisson_ratio")

    def test_a_needle_that_stands_already_is_left_out(self):
        world = study.World(self.model)
        self.assertEqual(world.old_paths, 0)
        motion = acus.Insertion(0.03, 0.1)
        motion(world)
        later = study.World(self.model)
        later.state = world.state.copy()
        later.old_paths = len(later.state.paths)
        later.reports = world.reports
        judged = approach.Judged(TARGET).of(later, later.needle())
        self.assertEqual(judged["cut"], "[]")

    def test_a_needle_spins_no_faster_than_the_scene_lets_it(self):
        with self.assertRaisesRegex(acus.PlanError, "scene: the needle's max_spin_speed is 5 rad/s; half a turn"):
            self.scene["needles[0].max_spin_speed"] = 5.0
            self.plan(TARGET, ENTRIES)
        self.scene["needles[0].max_spin_speed"] = 30.0
        plans = self.plan(TARGET, ENTRIES, cases=20, samples=1, uncertain={})
        for plan in plans:
            self.assertLessEqual(plan.motion.spin_rate, 27.0)
            self.assertNotIn("base_limited", plan.run().flags)

    def test_a_wall_is_said(self):
        plans = self.plan(TARGET, ENTRIES, {"wall": {"box": {"min": [-1, -1, 0.02], "max": [1, 1, 0.03]}}}, cases=20, samples=1, uncertain={})
        self.assertEqual(plans[0].probability, 0)
        self.assertIn("no plan succeeds in any sample; no plan keeps clear of wall", str(plans))

    def test_the_best_of_a_kind_are_unlike_each_other(self):
        problem = Insertions.problem(self)
        end = candidates.Outcome(np.zeros(3), 0.1, np.zeros((0, 3)), np.zeros((0, 3)), {}, 0.06)
        many = [candidates.Candidate(np.array([0, 0, TOP]), np.array([0, 0, -1.0]), turn=0.01 * i, end=end) for i in range(50)]
        self.assertEqual(len(planner.spread_out(problem, many, 10)), 3)  # 0, 0.2 and 0.4


# ---- Implants ----


class Implanted(OfPlans):
    """Two needles, five seeds, in the scene that all tests of studies use."""

    def setUp(self):
        super().setUp()
        self.scene = acus.Scene.read(self.write_scene())
        self.scene["tissue.mesh.box.cells"] = [4, 4, 4]
        self.seeds = {"left": [(0.003, 0.002, 0.01), (0.003, 0.002, 0.025)], "right": [(0.03, 0, z) for z in (0.03, 0.0, 0.015)]}

    def implant(self, **settings):
        return acus.plan.implant(self.scene, self.seeds, **{"folder": self.path("implant"), "progress": False, "workers": 0, "orders": 2, "samples": 2,
                                                            "speed": 0.1, **settings})

    def test_seeds_come_nearer_to_their_targets(self):
        plan = self.implant()
        self.assertEqual((plan.straight.shape, plan.errors.shape, plan.samples.shape), ((5,), (5,), (2, 5)))
        self.assertGreater(plan.straight.mean(), 1e-3)
        self.assertLess(plan.errors.mean(), 0.5 * plan.straight.mean(), plan)
        self.assertLess(plan.samples.mean(), 0.5 * plan.straight_samples.mean())
        self.assertIn("implant of 5 seeds by 2 needles", repr(plan))
        self.assertEqual(sorted(plan.order), ["left", "right"])
        scene, trajectory = plan.write(self.path("written"))
        begin = plan.motion.bodies(MODELS.load(self.scene))
        loaded = MODELS.load(acus.Scene.read(scene))
        for needle in loaded.needles:
            np.testing.assert_array_equal(needle.base_position, begin[needle.name][0])
        world = study.World(loaded)
        study.Trajectory(trajectory)(world)
        for needle in world.needles:  # out again
            np.testing.assert_allclose(world.report[needle.name].base_position, needle.base_position, atol=1e-5)

    def test_where_a_seed_lies_is_told_in_tissue_at_rest(self):
        motion = acus.plan.Implantation(("right",), ((0.0, 0.0, 0.0),), ((0.04, 0.02),), 0.1)
        model = MODELS.load(self.scene)
        world = study.World(model, bodies=motion.bodies(model))
        motion(world)
        deep, shallow = world.notes["seeds"]["right"]
        self.assertLess(abs((shallow - deep)[2] - 0.02), 5e-3)
        self.assertGreater(deep[2], 0.06 - 0.04)  # the tissue went along

    def test_a_seed_that_never_gets_into_the_tissue_is_named(self):
        self.scene["tissue.regions[gel].interaction.puncture_force"] = math.inf
        self.seeds = {"left": [(0.003, 0.002, 0.04)]}
        with self.assertRaisesRegex(acus.PlanError, "seeds\\[left\\]: that for .* outside the tissue in every order"):
            self.implant(speed=0.2)

    def test_errors_name_the_needle(self):
        for seeds, text in (({}, "seeds: expected {needle: targets}"), ({"middle": [(0, 0, 0)]}, "seeds\\[middle\\]: .* no needle"),
                            ({"left": []}, "seeds\\[left\\]: expected one target or more"), ({"left": [(0, 0, 1)]}, "seeds\\[left\\]: .* not inside the tissue"),
                            ({"left": [(0, 0)]}, "seeds\\[left\\]: expected 3 finite numbers")):
            self.seeds = seeds
            with self.assertRaisesRegex(acus.PlanError, text):
                self.implant()


# ---- Steering ----


class Steered(OfPlans):
    """The scene is believed; the truth has a softer tissue. 50 Hz, so that predictions are short."""

    def setUp(self):
        super().setUp()
        self.scene["rate"] = 50
        self.model = MODELS.load(self.scene)
        self.motion = acus.Insertion(0.072, 0.02, entry=(0, 0, TOP), direction=(0, 0, -1), flips=(0.03,))
        world = self.world(self.motion)
        self.target = tuple(tissue.Deformed(self.model, world.state.tissue_positions).at_rest(world.state.needle_positions("needle")[-1:])[0])

    def insert(self, next_stride, factors, noise=2e-4, delay=0):
        """mm, from the tip to the target; measured tips and targets come `delay` strides late."""
        scene = self.scene.copy()
        uncertain.Factors()(scene, factors)
        model = MODELS.load(scene)
        world, random, count, late = study.World(model, bodies=self.motion.bodies(model)), np.random.default_rng(1), 0, [[] for _ in range(1 + delay)]
        needle, target = world.needle(), approach.TissuePoint(model, self.target, "target")
        while places := next_stride(late.pop(0)):
            measured = []
            for place in places:
                world.drive(needle, *place)
                world.step()
                count += 1
                seen = (world.state.needle_positions(needle.name)[-1], target.at(world.state))
                measured.append((count, *(each + random.normal(scale=noise, size=3) for each in seen)))
            late.append(measured)
        world.settle(needle)
        return 1e3 * np.linalg.norm(target.at(world.state) - world.state.needle_positions(needle.name)[-1])

    def steering(self, **settings):
        return acus.plan.Steering(self.scene, self.target, self.motion, **settings)

    def test_what_is_as_believed_goes_as_planned(self):
        steering = self.steering()
        self.assertLess(self.insert(steering.next, {}, noise=0), 0.3)
        self.assertEqual(steering.belief.factors, {})
        self.assertLess(np.linalg.norm(steering.expected), 1e-4)
        self.assertEqual(steering.next(), [])

    def test_measured_tips_correct_what_was_misjudged(self):
        planned = iter([self.motion.places(study.World(self.model))])
        as_planned = self.insert(lambda _: next(planned, []), {"stiffness": 0.2})
        self.assertGreater(as_planned, 2.5)
        self.assertLess(self.insert(self.steering().next, {"stiffness": 0.2}), 0.5)
        self.assertLess(self.insert(self.steering().next, {"stiffness": 0.2}, delay=1), 0.25 * as_planned)  # a stride of 5 mm late

    def test_a_course_turns_at_rest_and_goes_on_where_it_was(self):
        course = acus.plan.Course(0.01, 0.5, (0.013, 0.018), 1e-3, 0.02)
        places, after, ended = course.stride(5e-3, turn=-1.0)
        advances, spins = np.transpose(places)
        self.assertTrue(np.all(np.diff(advances) >= 0))
        np.testing.assert_allclose(spins[advances <= 0.01][-1], -0.5)
        np.testing.assert_allclose(places[-1], (0.015, -0.5 + math.pi))
        self.assertEqual((after.flips, ended), ((0.018,), False))
        whole, _, ended = course.stride(1.0, end=0.02)
        self.assertTrue(ended)
        np.testing.assert_allclose(whole[-1], (0.02, 0.5 + 2 * math.pi))
        parts, now = [], course
        for _ in range(3):
            part, now, _ = now.stride(3e-3)
            parts += part
        np.testing.assert_allclose(parts, course.stride(9e-3)[0], atol=1e-12)
        self.assertEqual(course.with_flip(0.019).flips, (0.019,))

    def test_what_cannot_be_steered_is_said(self):
        spun = dataclasses.replace(self.motion, spin_rate=10.0)
        for settings, text in (((self.scene, self.target, acus.Insertion(0.05)), "with entry and direction"), ((self.scene, self.target, spun), "does not spin"),
                               ((self.scene, (1, 0, 0), self.motion), "not inside the tissue")):
            with self.assertRaisesRegex(acus.PlanError, text):
                acus.plan.Steering(*settings)
        self.steering().next((count, self.target) for count in range(1))  # any iterable
        for settings, text in (({"stride": 0}, "stride"), ({"beliefs": []}, "beliefs: expected a list"), ({"beliefs": [{"softness": 1}]}, "stiffness, friction, bevel"),
                               ({"beliefs": [{"bevel": -1}]}, "beliefs: bevel: expected a number above 0")):
            with self.assertRaisesRegex(acus.PlanError, text):
                self.steering(**settings)


if __name__ == "__main__":
    unittest.main()
