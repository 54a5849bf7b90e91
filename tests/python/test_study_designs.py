#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.study: which cases there are, and what their outputs depend on."""

import math
import os
import unittest

import numpy as np

from of_studies import STIFFNESS, OfStudies
from small_scene import InTemporaryFolder

import acus  # noqa: E402
from acus import study  # noqa: E402


# ---- Designs ----


class Designs(unittest.TestCase):
    def test_grid(self):
        made = study.grid({"a": [1, 2], "b": np.array([0.5, 1.5, 2.5])})
        self.assertEqual([made[i] for i in (0, 1, 5)], [{"a": 1, "b": 0.5}, {"a": 1, "b": 1.5}, {"a": 2, "b": 2.5}])
        self.assertEqual(len(made), 6)

    def test_latin_hypercube_has_one_case_in_each_share(self):
        made = study.latin_hypercube({"a": (0, 1), "b": study.LogUniform(1, 100)}, 50, seed=3)
        for values in zip(*made.rows):
            scaled = np.array(values) if max(values) <= 1 else np.log(values) / np.log(100)
            self.assertEqual(sorted((scaled * 50).astype(int)), list(range(50)))
        self.assertEqual(made.rows, study.latin_hypercube({"a": (0, 1), "b": study.LogUniform(1, 100)}, 50, seed=3).rows)

    def test_sobol_fills_evenly_and_goes_on(self):
        try:
            longer = study.sobol({"a": (0, 1), "b": (-1, 1)}, 64, seed=1)
        except acus.StudyError as error:
            self.skipTest(f"SKIPPED: {error}")
        self.assertEqual(longer.rows[:20], study.sobol({"a": (0, 1), "b": (-1, 1)}, 20, seed=1).rows)
        a, b = np.transpose(longer.rows)
        self.assertEqual(np.histogram2d(a, b, 8, [[0, 1], [-1, 1]])[0].tolist(), [[1] * 8] * 8)

    def test_tables(self):
        with_names = [{"a": 1, "b": "x"}, {"a": 2, "b": "y"}]
        for given in (with_names, {"a": [1, 2], "b": ["x", "y"]}):
            self.assertEqual(study.table(given).rows, [[1, "x"], [2, "y"]])
        for wrong in ([], {"a": [1], "b": [1, 2]}, "nowhere.csv", {"a": 5}, 5, [1, 2], None):
            self.assertRaises(acus.StudyError, study.table, wrong)

    def test_distributions(self):
        u = np.linspace(0, 1, 20001)[:-1]
        normal = np.array([study.Normal(3, 2).at(each) for each in u])
        self.assertAlmostEqual(normal.mean(), 3, 2)
        self.assertAlmostEqual(normal.std(), 2, 2)
        bounded = [study.Normal(0, 1, low=0.5, high=1).at(each) for each in u]
        self.assertTrue(min(bounded) >= 0.5 and max(bounded) <= 1)
        self.assertEqual({study.Choice(1, 2, 3).at(each) for each in u}, {1, 2, 3})
        for wrong in (lambda: study.Uniform(2, 1), lambda: study.LogUniform(0, 1), lambda: study.Normal(0, 0), study.Choice,
                      lambda: study.Normal(0, 1, 50, 60), lambda: study.Uniform(math.nan, 1)):
            self.assertRaises(ValueError, wrong)
        for wrong in ({"a": (1, 2, 3)}, {"a": 5}, {"a": (0, math.inf)}, {}):
            self.assertRaises(acus.StudyError, study.latin_hypercube, wrong, 4)
        self.assertRaisesRegex(acus.StudyError, "count", study.latin_hypercube, {"a": (0, 1)}, 0)


# ---- What outputs depend on ----


def ishigami(x):
    return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


class Files(InTemporaryFolder):
    def test_cells_are_numbers_truths_or_texts(self):
        made = study.table(self.write("t.csv", "a,b,c,d\n1,0.5,False,x\n2,1e3,TRUE,5 mm\n"))
        self.assertEqual(made.rows, [[1, 0.5, False, "x"], [2, 1e3, True, "5 mm"]])
        self.assertRaisesRegex(acus.StudyError, "t.csv:2: expected 2 cells", study.table, self.write("t.csv", "a,b\n1\n"))


class Sensitivity(unittest.TestCase):
    """Against Ishigami's function, whose indices have a closed form."""

    @classmethod
    def setUpClass(cls):
        a, b = 7.0, 0.1
        of_1, of_2, of_13 = (1 + b * math.pi**4 / 5) ** 2 / 2, a**2 / 8, b**2 * math.pi**8 * (1 / 18 - 1 / 50)
        variance = of_1 + of_2 + of_13
        cls.first, cls.total = np.array([of_1, of_2, 0]) / variance, np.array([of_1 + of_13, of_2, of_13]) / variance

    def sample(self, count, seed=0):
        try:
            made = study.saltelli({name: (-math.pi, math.pi) for name in "abc"}, count, seed)
        except acus.StudyError as error:
            self.skipTest(f"SKIPPED: {error}")
        return made, ishigami(np.array(made.rows))

    def test_indices_are_those_of_the_closed_form(self):
        made, values = self.sample(4096)
        self.assertEqual(len(made), 4096 * 5)
        found = study.sobol_indices(made.names, values)
        np.testing.assert_allclose([each.first for each in found], self.first, atol=0.006)  # 0.0022
        np.testing.assert_allclose([each.total for each in found], self.total, atol=0.0015)  # 0.0005

    def test_intervals_hold_the_truth_as_often_as_they_say(self):
        held, widths = [], {}
        for count in (64, 256):
            for seed in range(6):
                made, values = self.sample(count, seed)
                for index, first, total in zip(study.sobol_indices(made.names, values), self.first, self.total):
                    held += [index.first_interval[0] <= first <= index.first_interval[1],
                             index.total_interval[0] <= total <= index.total_interval[1]]
                    widths.setdefault(count, []).append(np.ptp(index.total_interval))
        self.assertGreater(np.mean(held), 0.9)  # 0.99
        self.assertTrue(1.5 < np.mean(widths[64]) / np.mean(widths[256]) < 2.7)  # 2.1, about with the root of the count

    def test_a_constant_shift_and_a_scale_do_not_matter(self):
        made, values = self.sample(128)
        for index, other in zip(study.sobol_indices(made.names, values), study.sobol_indices(made.names, 1e3 + 1e-3 * values)):
            self.assertAlmostEqual(index.first, other.first, 6)
            self.assertAlmostEqual(index.total, other.total, 6)

    def test_cases_without_a_number_are_left_out_with_their_row(self):
        made, values = self.sample(512)
        holes = values.copy()
        holes[[3, 600, 2000]] = np.nan
        for index, other in zip(study.sobol_indices(made.names, values), study.sobol_indices(made.names, holes)):
            self.assertNotEqual(index.first, other.first)
            self.assertAlmostEqual(index.first, other.first, 1)
        for wrong, what in ((np.full(len(values), np.nan), "whole rows"), (np.ones(len(values)), "the same in all")):
            self.assertRaisesRegex(acus.StudyError, what, study.sobol_indices, made.names, wrong)
        self.assertRaisesRegex(acus.StudyError, "n \\(3 \\+ 2\\) values", study.sobol_indices, made.names, values[1:])
        self.assertRaisesRegex(acus.StudyError, "confidence", study.sobol_indices, made.names, values, 95)

    def test_a_longer_sample_has_the_cases_of_a_shorter_one(self):
        shorter, longer = ({tuple(row) for row in self.sample(count)[0].rows} for count in (32, 64))
        self.assertLess(shorter, longer)


class Noise(OfStudies):
    def test_what_a_motion_draws_is_no_influence(self):
        def noisy(world):
            world.needle()
            world.step()

        try:
            cases = study.saltelli({"a": (0, 1), "b": (0, 1)}, 32)
        except acus.StudyError as error:
            self.skipTest(f"SKIPPED: {error}")
        made = self.run_study(cases, motion=noisy, outputs={"x": lambda r: r.parameters["a"] + r.world.random.normal()})
        first, second = made.indices("x")
        self.assertEqual(second.total, 0.0)
        self.assertGreater(first.total, 0.0)


class Pictures(OfStudies):
    def test_of_indices_and_spread(self):
        try:
            import matplotlib  # noqa: F401  pylint: disable=import-outside-toplevel,unused-import
            cases = study.saltelli({STIFFNESS: study.LogUniform(2e3, 2e4), "motion.tilt": (0.0, 0.2)}, 8)
        except (ImportError, acus.StudyError) as error:
            self.skipTest(f"SKIPPED: {error}")
        made = self.run_study(cases)
        swings = study.sensitivity.swings({"x": [1, 2, 3, 4], "text": list("abcd"), "same": [1] * 4}, [1.0, math.nan, 5.0, 7.0], 0.3)
        self.assertEqual(swings, {"x": (1.0, 7.0)})
        self.assertEqual(study.sensitivity.swings({"x": range(10)}, range(10)), {"x": (0.0, 9.0)})
        self.assertEqual(study.sensitivity.swings({"x": [1, 1, 1, 2, 2, 2]}, range(6)), {"x": (1.0, 4.0)})
        self.assertEqual(made.indices("tip.y")[0].name, STIFFNESS)
        stiffness, tilt = made.indices("tip.y")
        self.assertGreater(tilt.total, 5 * stiffness.total)  # tilted towards +y
        made.draw(self.path("a.png"))
        made.draw(self.path("b.svg"), "peak_force")
        made.draw_spread(self.path("c.png"))
        self.assertGreater(min(os.path.getsize(self.path(name)) for name in ("a.png", "b.svg", "c.png")), 8000)
        for call, what in ((lambda: made.draw(self.path("a.gif5")), "a.gif5"), (lambda: made.draw(self.path("a.png"), "x"), "no column"),
                           (lambda: made.draw_spread(self.path("a.png"), "peak_force"), "no column")):
            self.assertRaisesRegex(acus.AcusError, what, call)

    def test_of_a_case(self):
        try:
            import matplotlib  # noqa: F401  pylint: disable=import-outside-toplevel,unused-import
        except ImportError:
            self.skipTest("SKIPPED: matplotlib is missing (python3-matplotlib)")
        self.study().case(3).draw(self.path("case.png"), target=(0, 0, 0.02))
        self.assertGreater(os.path.getsize(self.path("case.png")), 5000)

    def test_what_has_not_run_has_no_picture(self):
        made = self.study()
        self.assertRaisesRegex(acus.StudyError, "cases that have run", made.draw, self.path("a.png"))
        self.assertRaisesRegex(acus.StudyError, "saltelli", made.indices, "peak_force")
        self.assertRaisesRegex(acus.StudyError, "no column", made.draw_spread, self.path("a.png"))


if __name__ == "__main__":
    unittest.main()
