#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.env: tasks are solved by scripts, episodes repeat bit by bit, worlds run side by side."""

import importlib.util
import os
import unittest

import numpy as np

from small_scene import InTemporaryFolder

import acus  # noqa: E402
from acus.env import POLICIES, LogUniform, NeedleEnv, Outcome, Task, VectorEnv  # noqa: E402
from acus.env.interface import Box, Discrete  # noqa: E402
from acus.env.speed import measure, measure_together  # noqa: E402
from acus.tissue_points import TissuePoints  # noqa: E402


PLACES = ["engine", "server"] if acus.engine.available() else ["server"]


def play(env, policy, **reset):
    """(observations, rewards, info of the last step, whether it was cut short)"""
    observation, _ = env.reset(**reset)
    observations, rewards = [observation], []
    while True:
        observation, reward, terminated, truncated, info = env.step(policy(observation))
        observations.append(observation)
        rewards.append(reward)
        if terminated or truncated:
            return observations, rewards, info, truncated


class Tasks(unittest.TestCase):
    def solve(self, task, seeds, **arguments):
        env = NeedleEnv(task, **arguments)
        self.addCleanup(env.close)
        for seed in seeds:
            observations, rewards, info, _ = play(env, POLICIES[task], seed=seed)
            self.assertTrue(info["success"], (task, seed, info))
            for observation in observations:
                self.assertIn(observation, env.observation_space)
        return env, rewards, info

    def test_reach_is_solved_by_turning_the_bevel_to_the_target(self):
        env, rewards, _ = self.solve("reach", range(3))
        self.assertGreater(sum(rewards), 60)
        for action, past in (([1, 0], True), ([0, 0], False)):  # drifts away; waits
            _, _, info, truncated = play(env, lambda _, action=action: action,
                                         options={"target": [0, 0, -0.01]})
            self.assertEqual((info["success"], truncated), (False, not past))

    def test_the_force_limit_is_held_by_slowing_down(self):
        env, _, info = self.solve("force_limit", [0])
        self.assertLess(info["peak"], 1.25)
        _, rewards, info, _ = play(env, lambda _: [1.0], seed=0)
        self.assertGreater(info["peak"], 1.25)
        self.assertLess(rewards[-1], -9)
        _, _, info, _ = play(env, lambda _: [1.0], seed=0, options={"limit": 10})
        self.assertTrue(info["success"])

    def test_the_needle_that_matters_goes_in_last(self):
        env, rewards, info = self.solve("needle_order", [0], randomise=True)
        self.assertAlmostEqual(rewards[-1], -1e3 * info["miss"])
        chosen = env.task.chosen
        order = iter([chosen, chosen, *(i for i in range(6) if i != chosen)])
        _, rewards, info, _ = play(env, lambda _: next(order), options={"chosen": chosen})
        self.assertFalse(info["success"])
        self.assertEqual(rewards[1], -1)  # it stood already


class Episodes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.env = NeedleEnv("reach", randomise={"tissue.regions[gel].material.young_modulus": LogUniform(15e3, 60e3),
                                                "needles[0].cutting_direction[1]": (0.08, 0.15)})
        cls.addClassCleanup(cls.env.close)

    def test_they_repeat_bit_by_bit(self):
        first = play(self.env, POLICIES["reach"], seed=5)
        other = play(self.env, POLICIES["reach"], seed=6)
        again = play(self.env, POLICIES["reach"], seed=5)
        np.testing.assert_array_equal(first[0], again[0])
        self.assertEqual(first[1], again[1])
        self.assertNotEqual(first[1], other[1])

    def test_parameters_are_drawn_or_given(self):
        _, info = self.env.reset(seed=1)
        _, same = self.env.reset(seed=1)
        _, other = self.env.reset()
        self.assertEqual(info["parameters"], same["parameters"])
        self.assertNotEqual(info["parameters"], other["parameters"])
        for place, value in ((0, 15e3), (1, 0.08)):
            self.assertGreater(list(info["parameters"].values())[place], value)
        given = {"tissue.regions[gel].material.young_modulus": 20e3, "needles[0].cutting_direction[1]": 0.1,
                 "tissue.regions[gel].interaction.cutting_force": 0.25}
        _, info = self.env.reset(options={"parameters": given})
        self.assertEqual(info["parameters"], given)
        self.assertRaises((acus.Refused, acus.SceneError), self.env.reset, options={"parameters": {"tissue.colour.red": 1}})

    @unittest.skipUnless(acus.engine.available() and importlib.util.find_spec("matplotlib") and importlib.util.find_spec("PIL"),
                         "SKIPPED: the engine, matplotlib or pillow is missing")
    def test_a_picture_shows_the_needle_and_its_target(self):
        with NeedleEnv("reach", render_mode="rgb_array") as env:
            env.reset(seed=1, options={"target": [0.0, 0.005, 0.0]})
            before = env.render()
            self.assertEqual((before.shape, before.dtype), ((480, 640, 3), np.uint8))
            np.testing.assert_array_equal(env.render(), before)
            red = np.all(before == [204, 0, 0], axis=2)
            self.assertGreater(red.sum(), 30)
            for _ in range(30):
                observation = env.step([1, 0])[0]
            self.assertGreater(observation[8], 1)
            self.assertGreater(np.any(env.render() != before, axis=2).sum(), 100)
        for env, what in ((NeedleEnv("reach"), "render_mode='rgb_array'"), (NeedleEnv("reach", on="server", render_mode="rgb_array"), "on='engine'")):
            with env:
                env.reset(seed=1)
                self.assertRaisesRegex(acus.EnvError, what, env.render)
        self.assertRaisesRegex(acus.EnvError, "render_mode: expected None or 'rgb_array'", NeedleEnv, "reach", render_mode="human")

    def test_what_there_is_no_task_for(self):
        self.assertRaisesRegex(ValueError, "reach, force_limit, needle_order", NeedleEnv, "dance")

    def test_what_cannot_be_done_is_refused_and_changes_nothing(self):
        self.assertRaisesRegex(acus.EnvError, "reset\\(\\) begins one", NeedleEnv("reach").step, [0, 0])
        self.assertRaisesRegex(acus.EnvError, "did you mean 'randomise'", NeedleEnv, "reach", randomize=True)
        self.assertRaisesRegex(acus.EnvError, "no argument 'speed'; those of Server are", NeedleEnv, "reach", speed=2)
        wrong = {"reach": ([[np.nan, 0], [1], "go"], [{"target": [np.nan] * 3}, {"target": 1}, {"limit": 1}]),
                 "force_limit": ([[np.inf], []], [{"limit": 0}, {"limit": np.nan}, {"target": [0, 0, 0]}]),
                 "needle_order": ([-1, 6, 1.5, [1, 2]], [{"chosen": 9}, {"chosen": 1.5}])}
        for task, (actions, options) in wrong.items():
            env, other = NeedleEnv(task), NeedleEnv(task)
            self.addCleanup(env.close)
            for each in options:
                with self.subTest(task=task, options=each):
                    self.assertRaisesRegex(ValueError, "options", env.reset, options=each)
            env.reset(seed=1)
            other.reset(seed=1)
            for each in options:  # in an episode, which goes on
                self.assertRaisesRegex(ValueError, "options", env.reset, seed=9, options=each)
            for action in actions:
                with self.subTest(task=task, action=action):
                    self.assertRaises(ValueError, env.step, action)
            action = env.action_space.sample()
            np.testing.assert_array_equal(env.step(action)[0], other.step(action)[0])
            other.close()
            self.assertRaisesRegex(ValueError, "closed", other.step, action)
            other.close()  # once more does nothing
        self.assertRaisesRegex(ValueError, "at least 1", VectorEnv, 0)
        worlds = VectorEnv(2, "reach")
        worlds.reset(seed=1)
        self.assertRaisesRegex(ValueError, "finite", worlds.step, [[0, 0], [np.nan, 0]])
        self.assertEqual([info["tick"] for info in worlds.step([[0, 0], [0, 0]])[4]], [8, 8])  # none had stepped
        worlds.close()
        self.assertRaisesRegex(ValueError, "closed", worlds.reset)

    @unittest.skipUnless(importlib.util.find_spec("gymnasium"), "Gymnasium is not installed")
    def test_gymnasium_has_nothing_to_complain_of(self):
        from gymnasium.utils.env_checker import check_env
        check_env(self.env, skip_render_check=True)


class Waiting(Task):
    """One's own task: nothing moves. The third step fails."""

    action_space = Discrete(2)
    observation_space = Box(-np.inf, np.inf, (1,))
    steps = 2

    def scene(self):
        return acus.Scene({"tissue": {"rung": "none"}, "needles": [{"name": "n"}]})

    def begin(self, world, random, options):
        self.offset = random.uniform()

    def act(self, world, action):
        if action == 1:
            raise acus.AcusError("asked to fail")
        world.step(1)

    def observe(self, world):
        return [self.offset + world.states.tick]

    def judge(self, world):
        return Outcome(1.0, False, False, {})


def waiting():
    return NeedleEnv(Waiting())


class Places(unittest.TestCase):
    def test_the_engine_and_a_server_give_the_same_bytes(self):
        episodes = []
        for on in PLACES:
            env = NeedleEnv("reach", on=on)
            self.addCleanup(env.close)
            episodes.append(play(env, POLICIES["reach"], seed=5))
        for other in episodes[1:]:
            np.testing.assert_array_equal(episodes[0][0], other[0])
            self.assertEqual(episodes[0][1], other[1])

    def test_what_does_not_go_together_is_told(self):
        self.assertRaisesRegex(ValueError, "'engine' or 'server'", NeedleEnv, on="moon")
        self.assertRaisesRegex(ValueError, "arguments of Server, found rate", NeedleEnv, on="engine", rate=100)
        env = NeedleEnv(Waiting(), on=PLACES[0])
        self.addCleanup(env.close)
        if PLACES[0] == "engine":
            self.assertRaisesRegex(AttributeError, "on='server'", lambda: env.world.client)


class Worlds(unittest.TestCase):
    def test_they_do_what_one_does_alone(self):
        for on in PLACES:
            with self.subTest(on=on):
                self.do_what_one_does_alone(on)

    def do_what_one_does_alone(self, on):
        with VectorEnv(2, "reach", on=on) as worlds:
            observations, _ = worlds.reset(seed=3)
            self.assertEqual(observations.shape, (2, 10))
            rows = [observations]
            for _ in range(5):
                actions = [POLICIES["reach"](observation) for observation in rows[-1]]
                observations, rewards, terminated, truncated, infos = worlds.step(actions)
                self.assertEqual((rewards.shape, terminated.dtype, truncated.dtype, len(infos)), ((2,), bool, bool, 2))
                rows.append(observations)
        env = NeedleEnv("reach", on=on)
        self.addCleanup(env.close)
        observation, _ = env.reset(seed=4)  # the second world's
        for row in rows:
            np.testing.assert_array_equal(row[1], observation)
            observation = env.step(POLICIES["reach"](observation))[0]

    def test_an_episode_that_is_over_begins_anew_and_trouble_is_told(self):
        with VectorEnv(2, make=waiting) as worlds:
            self.assertEqual(worlds.single_action_space.n, 2)
            first, _ = worlds.reset(seed=[1, 1])
            self.assertEqual(first[0], first[1])
            worlds.step([0, 0])
            observations, _, _, truncated, infos = worlds.step([0, 0])
            self.assertTrue(truncated.all())
            self.assertAlmostEqual(infos[1]["final_observation"][0] - first[1, 0], 2, places=5)
            self.assertNotEqual(observations[0], first[0])
            processes = worlds._worlds._processes
            self.assertRaisesRegex(acus.AcusError, "world 1: .*(?s:.*)asked to fail", worlds.step, [0, 1])
            self.assertRaisesRegex(ValueError, "expected 2", worlds.step, [0])
            processes[1].join()
            self.assertRaisesRegex(acus.AcusError, "world 1: its process has ended", worlds.step, [0, 0])
        self.assertEqual([process.exitcode for process in processes], [0, 0])


class Parts(InTemporaryFolder):
    def test_places_move_with_the_tissue(self):
        random = np.random.default_rng(2)
        nodes = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], dtype=np.float32)

        class Described:
            positions = nodes
            tetrahedra = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])

        places = np.array([[0.2, 0.1, 0.3], [0.6, 0.6, 0.6], [0, 0, 0]])
        points = TissuePoints(Described, places)
        np.testing.assert_allclose(points.at(nodes), places, atol=1e-6)
        turned = random.normal(size=(3, 3))
        np.testing.assert_allclose(points.at(nodes @ turned + 5), places @ turned + 5, atol=1e-5)

    def test_spaces(self):
        box, choice = Box(np.array([0, -1], np.float32), np.array([1, 1], np.float32)), Discrete(3)
        for space in (box, choice):
            space.seed(1)
            self.assertTrue(all(space.sample() in space for _ in range(100)))
        self.assertFalse(box.contains(np.array([2, 0], np.float32)) or choice.contains(3))

    def test_speed_is_measured(self):
        for on in PLACES:
            found = measure("reach", on, episodes=1)
            self.assertGreater(found["steps_per_second"], 0)
            self.assertGreater(found["ticks"], found["steps"])
            self.assertTrue(0 < found["in_ticks"] < 1)
            self.assertGreater(measure_together("reach", on, 2, steps=2), 0)


if __name__ == "__main__":
    unittest.main()
