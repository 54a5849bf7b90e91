# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.fit and acus-fit: data, features, what is known of an answer, and synthetic truths found again."""

import json
import math
import os
import subprocess
import unittest

import numpy as np
from small_scene import ROOT, SCENE, InTemporaryFolder

import acus
from acus import engine
from acus.fit import Fit, Measurement, read_measurement, simulated
from acus.fit.curve import Curve
from acus.fit.features import features, first_peak, misfit
from acus.fit.identify import doubts, identify, independent_points

STIFFNESS = "tissue.regions[gel].material.young_modulus"
PUNCTURE = "tissue.regions[gel].interaction.puncture_force"
CUTTING = "tissue.regions[gel].interaction.cutting_force"
PUSH = acus.Insertion(0.045, 0.05)
TRUTH = {STIFFNESS: 8e3, PUNCTURE: 0.35, CUTTING: 0.2}


def with_truth(scene, values):
    scene = scene.copy()
    for name, value in values.items():
        scene[name] = value
    return scene


class Data(InTemporaryFolder):
    def read(self, text, **settings):
        return read_measurement(self.write("data.csv", text), PUSH, **settings)

    def test_units_and_names(self):
        rows = "\n".join(f"{x},{x * x},9" for x in range(6))
        for header, over, of, first in (("travel_mm,force_N,other", "travel", "force", 1e-3), ("depth (m), f (mN),", "travel", "force", 1.0),
                                        ("t_s;deflection_mm;x", "time", "deflection", 1.0), ("\ufeffTime_ms,Force_N,x", "time", "force", 1e-3)):
            with self.subTest(header):
                data = self.read(header + "\n" + (rows.replace(",", ";") if ";" in header else rows))
                self.assertEqual((data.over, data.of, data.name), (over, of, "data.csv"))
                self.assertAlmostEqual(data.x[1], first)
        self.assertAlmostEqual(self.read("# measured\ntravel_mm,force_mN\n" + rows).y[2], 4e-3)
        self.assertEqual(self.read(rows, columns=["time_s", "force_N", ""]).over, "time")
        self.assertEqual(self.read("time_s,force_N,travel_mm\n" + rows, columns=["time_s", "force_N"]).over, "time")

    def test_what_cannot_be_used_is_told(self):
        rows = "0,1\n1,2\n2,4\n3,5\n"
        for text, settings, what in (("", {}, "no rows"), (rows, {}, "no names of columns; give them"), ("a,b\n" + rows, {}, "found a, b"),
                                     ("time_mm,force_N\n" + rows, {}, "one column of time"), ("time_s,travel_mm,force_N\n0,1,2\n", {}, "one column of time"),
                                     ("time,force\n" + rows, {}, "with units"), (rows, {"columns": ["time_s", "x"]}, "one column of time"),
                                     ("time_s,force_N\n" + rows, {"columns": ["t_s"]}, "no column t_s; it has time_s, force_N"),
                                     ("# a\ntime_s,force_N\n0,1\nx,2\n", {}, "csv:4: column time_s: expected a number, found 'x'"),
                                     ("time_s,force_N\n0,1\n1\n", {}, "csv:3: column force_N: expected a number, found none"), ("time_s,force_N\n0,1\n", {}, "at least 4"),
                                     ("time_s,force_N\n0,1\n1,1\n2,1\n3,1\n", {}, "nothing to fit"), ("time_s,force_N\n0,0\n1,0\n2,0\n3,0\n4,1\n", {"until": 3}, "nothing to fit"),
                                     ("time_s,force_N\n" + rows, {"until": 1}, "fewer than 4 points are before it"),
                                     ("time_s,force_N\n" + rows, {"until": 30}, "all data are before it, they end at 3 s")):
            with self.subTest(what), self.assertRaisesRegex(acus.AcusError, what):
                self.read(text, **settings)
        with self.assertRaisesRegex(acus.AcusError, "No such file"):
            read_measurement(self.path("none.csv"), PUSH)

    def test_over_travel_it_is_the_first_way_in(self):
        x = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, 0, 50)])
        data = Measurement(x, np.arange(100.0), "travel", "force", PUSH)
        self.assertLess(data.y.max(), 54)

    def test_dense_parts_of_a_digitised_curve_do_not_count_more(self):
        x = np.concatenate([np.linspace(0, 1, 50), np.full(5000, 0.5), [2.0]])
        data = Measurement(x, x**2, "time", "force", PUSH)
        dense = np.abs(data.x - 0.5) < 4e-3
        self.assertAlmostEqual(np.sum(data.weights[dense]), 1)
        self.assertEqual(data.weights[-1], 1)


class Features(unittest.TestCase):
    def test_of_a_puncture(self):
        x = np.linspace(0, 1, 201)
        y = np.where(x <= 0.4, x / 0.4, 0.3 + 0.4 * (x - 0.4))
        found = {name: value for name, (value, _) in features(x, y).items()}
        self.assertAlmostEqual(found["first_peak"], 1)
        self.assertAlmostEqual(found["at_first_peak"], 0.4)
        self.assertAlmostEqual(found["after_peak"], 0.302, places=6)
        self.assertAlmostEqual(found["half_rise"], 0.2)
        self.assertAlmostEqual(found["later_3"], y[-1])

    def test_a_first_peak_is_one_that_stands_out(self):
        self.assertIsNone(first_peak(np.array([0, 1, 0.95, 2, 3.0]), 0.5))
        self.assertEqual(first_peak(np.array([0, 1, 0.95, 2, 1.2, 3.0]), 0.5), 3)
        self.assertIsNone(first_peak(np.array([5, 4, 3, 2.0]), 0.5))

    def test_a_curve_without_the_puncture_of_the_other_is_far_off(self):
        x = np.linspace(0, 1, 201)
        y = np.where(x <= 0.4, x / 0.4, 0.3)
        misplaced = np.where(x <= 0.8, x / 0.8, 0.3)
        self.assertGreater(np.linalg.norm(misfit(features(x, y), features(x, x))), np.linalg.norm(misfit(features(x, y), features(x, misplaced))))
        self.assertEqual(np.linalg.norm(misfit(features(x, y), features(x, y))), 0)


class Curves(unittest.TestCase):
    def test_points_are_as_far_off_as_they_are_across_the_curve(self):
        x = np.linspace(0, 1, 101)
        step = Curve([0, 0.5, 0.5, 1], [0, 0, 1, 1])  # a tenth of the range of x is as long as that of y
        data = Measurement(x, (x > 0.52).astype(float), "time", "force", PUSH)
        off = step.misfit(data, data.fitted)
        np.testing.assert_allclose(off[:50], 0, atol=2e-3)
        self.assertAlmostEqual(np.abs(off).max(), 0.2, places=2)  # 0.02 to the side
        flat = Curve([0, 1], [0.3, 0.3])
        np.testing.assert_allclose(flat.misfit(data, data.fitted)[[0, 100]], [-0.3, 0.7], atol=1e-9)

    def test_before_it_begins_and_after_it_ends_a_curve_is_level(self):
        x = np.linspace(0, 1, 101)
        data = Measurement(x, np.clip(x - 0.3, 0, 0.5), "time", "force", PUSH)
        np.testing.assert_allclose(Curve([0.3, 0.8], [0, 0.5]).misfit(data, data.fitted), 0, atol=1e-3)

    def test_a_peak_that_is_too_high_is_seen_from_the_curve(self):
        x = np.linspace(0, 1, 101)
        data = Measurement(x, x, "time", "force", PUSH)
        spike = Curve([0, 0.5, 0.5, 0.5, 1], [0, 0.5, 1.5, 0.5, 1])
        self.assertLess(np.abs(spike.misfit(data, data.fitted)).max(), 0.01)
        self.assertGreater(np.abs(spike.excess(data, data.fitted)).max(), 0.9)


class Known(unittest.TestCase):
    def test_intervals_hold_the_truth_as_often_as_they_say(self):
        random, inside = np.random.default_rng(3), 0
        slopes = np.column_stack([np.linspace(1, 2, 60), np.sin(np.linspace(0, 9, 60))])
        for _ in range(400):
            noise = random.normal(0, 0.05, 60)
            error = np.linalg.lstsq(slopes, noise, rcond=None)[0]
            known = identify(noise - slopes @ error, slopes, 60)
            inside += abs(error[0]) <= known.half_width[0]
        self.assertGreater(inside / 400, 0.92)

    def test_parameters_that_the_data_tie_together_or_leave_alone(self):
        slope = np.linspace(1, 2, 80)
        noise = np.random.default_rng(4).normal(0, 0.1, 80)

        def found(slopes, place=(0.5, 0.5)):
            known = identify(noise, slopes, 80)
            low, high = (np.clip(place + sign * known.half_width, 0, 1) for sign in (-1, 1))
            return doubts(["a", "b"][:slopes.shape[1]], np.array(place), low, high, known.correlation, slopes, noise)

        self.assertIn("only together with b (correlation +1.000)", found(np.column_stack([slope, -slope * (1 + 1e-6)]))["a"])
        self.assertEqual(found(np.column_stack([slope, 1e-9 * slope[::-1]])), {"b": "the data hardly depend on it"})
        self.assertEqual(found(slope[:, None], (1.0,)), {"a": "it is at the upper limit of its range"})

    def test_points_that_follow_each_other_count_less(self):
        random = np.random.default_rng(5)
        each = np.arange(1000)
        self.assertGreater(independent_points(each, random.normal(size=1000)), 850)
        self.assertLess(independent_points(each, np.cumsum(random.normal(size=1000))), 30)
        self.assertLess(independent_points(each, 0.1 + random.normal(0, 0.01, 1000)), 20)  # all of them off alike
        self.assertLess(independent_points(np.concatenate([np.arange(50), np.full(2000, 25)]), random.normal(size=2050)), 55)


@unittest.skipUnless(engine.available(), "without the engine")
class Truths(InTemporaryFolder):
    def setUp(self):
        super().setUp()
        self.scene = acus.Scene.read(self.write_scene())

    def test_a_truth_is_found_again_and_predicts(self):
        data = simulated(with_truth(self.scene, TRUTH), PUSH, noise=5e-3, shift=2e-3, until=0.035)
        done = Fit(self.scene, data, {STIFFNESS: (4e3, 20e3), PUNCTURE: (0.2, 0.8), CUTTING: (0.1, 0.4),
                                      "data.shift": (0.0, 5e-3)}).run(progress=False, spread=10)
        for name, truth in {**TRUTH, "data.shift": 2e-3}.items():
            low, high = done.intervals[name]
            self.assertLess(abs(done.values[name] - truth), 0.03 * truth, name)
            self.assertTrue(low < done.values[name] < high, name)
            self.assertLess(high - low, 0.2 * truth, name)
        self.assertEqual(done.doubts, {})
        self.assertLess(done.rms[0], 7e-3)
        self.assertEqual(set(done.patch), set(TRUTH))
        self.assertAlmostEqual(done.scene()[PUNCTURE], done.values[PUNCTURE], places=5)
        beyond, = done.predictions
        self.assertGreater(beyond.x.min(), 0.035)
        self.assertLess(beyond.relative, 0.03)
        self.assertGreater(beyond.within, 0.9)
        other = done.predict(simulated(with_truth(self.scene, TRUTH), acus.Insertion(0.04, 0.1), over="time", shift=2e-3))
        self.assertLess(other.relative, 0.05)

    def test_what_the_data_do_not_tell(self):
        data = simulated(with_truth(self.scene, TRUTH), acus.Insertion(0.013, 0.05), noise=1e-3)  # it presses, and does not go in
        done = Fit(self.scene, data, {STIFFNESS: (2e3, 30e3), CUTTING: (0.03, 0.6)}).run(progress=False)
        self.assertLess(abs(done.values[STIFFNESS] - 8e3), 800)
        self.assertEqual(done.doubts, {CUTTING: "the data hardly depend on it"})
        self.assertIn("cannot be identified: the data hardly depend on it", str(done))

    def test_arguments(self):
        data = simulated(self.scene, PUSH)
        for parameters, what in (({}, "at least one"), ({STIFFNESS: 3}, "expected a range"), ({STIFFNESS: (3, 1)}, "from low to high"),
                                 ({"needles[0].lengt": (1, 2)}, "lengt"), ({"motion.sped": (1, 2)}, "motion.sped"),
                                 ({"needles[0].beams": (1, 9)}, "found one of the type integer"), ({"tissue.regions": (1, 2)}, "a field that is a number"),
                                 ({STIFFNESS: (-3, 1)}, "a range within 0.01 to 1e\\+13, found -3 to 1"),
                                 ({STIFFNESS: (1, 2), "tissue.regions[0].material.young_modulus": (1, 2)}, "are the same field")):
            with self.subTest(what), self.assertRaisesRegex(acus.AcusError, what):
                Fit(self.scene, data, parameters)
        short = Measurement(data.x, data.y, "travel", "force", acus.Insertion(0.01, 0.05))
        with self.assertRaisesRegex(acus.AcusError, "no case of 9 could be run, the first one: .*data go on to 0.045 m, the motion ends at 0.01 m"):
            Fit(self.scene, short, {STIFFNESS: (1e3, 2e3)}).run(progress=False)


@unittest.skipUnless(engine.available(), "without the engine")
class Program(InTemporaryFolder):
    def run_program(self, *arguments):
        return subprocess.run([os.path.join(ROOT, "client", "fit"), *arguments], capture_output=True, text=True, check=False, cwd=self.folder)

    def test_from_a_file_to_a_scene(self):
        self.write("small.yaml", SCENE.format(name="small").replace("puncture_force: 0.5", f"cutting_force: {TRUTH[CUTTING]}"))
        data = simulated(with_truth(acus.Scene.read(self.path("small.yaml")), TRUTH), PUSH, noise=5e-3)
        self.write("pushed.csv", "travel_mm,force_N\n" + "".join(f"{1e3 * x},{y}\n" for x, y in zip(data.x, data.y)))
        done = self.run_program("small.yaml", "pushed.csv", "--speed", "0.05", "--depth", "0.045", "--until", "0.035",
                                "--free", STIFFNESS + "=2e3:30e3", "--free", PUNCTURE + "=0.1:1")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("curves: step", done.stderr)
        self.assertIn("predicted with", done.stdout)
        with open(self.path("fits", "pushed", "fit.json"), encoding="utf-8") as file:
            told = json.load(file)
        self.assertTrue(told["parameters"][PUNCTURE]["identified"])
        self.assertAlmostEqual(told["patch"][PUNCTURE], acus.Scene.read(self.path("fits", "pushed", "scene.yaml"))[PUNCTURE], places=4)
        self.assertEqual(sorted(os.listdir(self.path("fits", "pushed"))), ["curves.csv", "fit.json", "fit.png", "scene.yaml"])
        self.assertTrue(math.isclose(told["predicted"][0]["relative"], 0, abs_tol=0.2))

    def test_bad_command_lines(self):
        self.write_scene()
        self.write("data.csv", "time_s,force_N\n0,0\n1,1\n2,2\n3,1\n")
        begin = ("small.yaml", "data.csv", "--speed", "0.05")
        for arguments, what in ((begin, "--free"), ((*begin, "--free", "x"), "expected NAME=LOW:HIGH"), ((*begin, "--free", "x=1:2"), "x"),
                                ((*begin, "--motion", "y", "--free", "x=1:2"), "not allowed"),
                                ((*begin, "--free", "data.shift=0:1", "--seed", "-1"), "whole number"),
                                ((*begin, "--free", "data.shift=0:1", "--folder", "data.csv"), "data.csv: File exists"),
                                (("small.yaml", "none.csv", "--speed", "0.05", "--free", "data.shift=0:1"), "none.csv"),
                                (("none.yaml", "data.csv", "--speed", "0.05", "--free", "data.shift=0:1"), "none.yaml")):
            done = self.run_program(*arguments)
            self.assertEqual((done.returncode, done.stdout), (1, ""), done.stderr)
            self.assertIn(what, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_results_replace_no_file_of_others(self):
        self.write_scene()
        self.write("data.csv", "time_s,force_N\n0,0\n1,1\n2,2\n3,1\n")
        for name in ("scene.yaml", "fit.json", "curves.csv", "fit.png"):
            mine = self.write(f"{name} results/{name}", "mine")
            done = self.run_program("small.yaml", "data.csv", "--speed", "0.05", "--free", STIFFNESS + "=2e3:30e3", "--folder", f"{name} results")
            self.assertEqual((done.returncode, done.stdout), (1, ""), done.stderr)
            self.assertIn(f"{name}: something else stands there", done.stderr)
            with open(mine, encoding="utf-8") as file:
                self.assertEqual(file.read(), "mine")


if __name__ == "__main__":
    unittest.main()
