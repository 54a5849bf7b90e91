#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The package's messages are those of protocol/: its fields, flags and errors are held against the C++ headers."""

import os
import pickle
import re
import types
import unittest

import numpy as np

from small_scene import ROOT

import acus  # noqa: E402
from acus import env, errors, messages, rotation, study  # noqa: E402

# What a class is called there, where it is not called the same.
NAMES = {"Needle": "NeedleInfo", "Guide": "GuideInfo", "TissueSize": "TissueInfo", "Topic": "TopicInfo",
         "NeedleAtRest": "NeedleRest", "Done": "Standing"}


def header(name):
    with open(os.path.join(ROOT, "protocol", name), encoding="utf-8") as file:
        return file.read()


def fields_of(struct):
    """Names in the list of a struct of messages.h; those of its base first."""
    body = re.search(rf"struct {struct}\b.*?\n}};", header("messages.h"), re.DOTALL)[0]
    base = fields_of("Standing") if "Standing::fields" in body else []
    return base + re.findall(r'visit\("(\w+)"', body)


class Contract(unittest.TestCase):
    def classes(self):
        return [each for each in vars(messages).values()
                if isinstance(each, type) and issubclass(each, messages.Message) and each is not messages.Message]

    def test_every_class_has_the_fields_of_the_contract(self):
        self.assertGreater(len(self.classes()), 12)
        for each in self.classes():
            expected = set(fields_of(NAMES.get(each.__name__, each.__name__))) - {"seq"}
            found = set(each.field_names()) | set(each.OPTIONAL)
            self.assertEqual(found - {"seq"}, expected, each.__name__)

    def test_flags_have_the_names_of_the_contract(self):
        text = header("enums.h")
        names = re.findall(r'"(\w+)"', text[text.index("kFlagNames{"):].split("};")[0])
        self.assertEqual(list(messages.FLAG_NAMES), names)
        self.assertEqual(messages.flag_names(1 << 5 | 1 << 10 | 1 << 30), ["not_finite", "step_limited"])

    def test_the_package_has_the_version_of_the_project(self):
        versions = []
        for path in ("CMakeLists.txt", "client/python/pyproject.toml"):
            with open(os.path.join(ROOT, path), encoding="utf-8") as file:
                versions.append(re.search(r'(?:project\(acus VERSION |\nversion = ")([0-9.]+)', file.read())[1])
        self.assertEqual(versions[0], versions[1])

    def test_the_version_is_that_of_the_contract(self):
        self.assertIn(f"kVersion = {messages.VERSION};", header("messages.h"))


class Errors(unittest.TestCase):
    def test_they_come_whole_out_of_another_process(self):
        refused = pickle.loads(pickle.dumps(errors.Refused("held", "by another", "acquire")))
        self.assertEqual((refused.code, refused.message, refused.rejected), ("held", "by another", "acquire"))
        self.assertEqual(str(refused), "the server refused 'acquire' (held): by another")
        failed = pickle.loads(pickle.dumps(errors.ServerFailed("ended", 2, "a log")))
        self.assertEqual((str(failed), failed.status, failed.log), ("ended", 2, "a log"))
        for each in vars(errors).values():
            if isinstance(each, type) and each is not errors.Refused:
                self.assertTrue(issubclass(each, errors.AcusError))
                self.assertEqual(str(pickle.loads(pickle.dumps(each("why")))), "why")


class Decoding(unittest.TestCase):
    MESSAGE = {"epoch": 0, "tick": 3, "time": 0.1, "needle": "n", "kind": "contact", "region": "r",
               "position": [1, 2, 3], "force": 0.5, "later": "unknown"}

    def test_unknown_fields_are_left_out_and_missing_ones_are_a_mismatch(self):
        event = messages.Event(self.MESSAGE)
        self.assertFalse(hasattr(event, "later"))
        np.testing.assert_array_equal(event.position, [1, 2, 3])
        for name, value in (("position", [1, 2]), ("position", "abc"), ("position", None)):
            self.assertRaises(errors.ProtocolMismatch, messages.Event, {**self.MESSAGE, name: value})
        self.assertRaises(errors.ProtocolMismatch, messages.Event, {"epoch": 0})

    def test_packed_arrays_have_their_shapes(self):
        shape = messages.TissueShape({"epoch": 0, "tick": 0, "time": 0,
                                      "positions": np.arange(6, dtype="<f4").tobytes(),
                                      "path_points": np.arange(9, dtype="<f4").tobytes(),
                                      "path_sizes": np.array([2, 1], "<i4").tobytes(),
                                      "dent_centres": np.arange(3, dtype="<f4").tobytes(),
                                      "dent_moves": np.array([0, 0, -1], "<f4").tobytes(),
                                      "dent_radii": np.array([1, 2], "<f4").tobytes()})
        np.testing.assert_array_equal(shape.positions, [[0, 1, 2], [3, 4, 5]])
        self.assertEqual([len(path) for path in shape.paths], [2, 1])
        np.testing.assert_allclose(acus.Dents.of(shape).displaced([0, 1, 2]), [0, 1, 1])


def public_names(of):
    return [name for name, value in vars(of).items()
            if not name.startswith("_") and not isinstance(value, types.ModuleType)]


class Package(unittest.TestCase):
    def test_one_version(self):
        for file, pattern in (("CMakeLists.txt", r"project\(acus VERSION (\S+)"), ("client/python/pyproject.toml", r'^version = "(.*)"')):
            with open(os.path.join(ROOT, file), encoding="utf-8") as text:
                self.assertEqual(re.search(pattern, text.read(), re.MULTILINE)[1], acus.__version__)
        self.assertTrue(os.path.exists(os.path.join(os.path.dirname(acus.__file__), "py.typed")))


class Page(unittest.TestCase):
    def test_docs_name_everything_that_is_public(self):
        words = set()
        for page in ("python.md", "studies.md", "plans.md", "fitting.md"):
            with open(os.path.join(ROOT, "docs", page), encoding="utf-8") as file:
                words.update(re.findall(r"\w+", file.read()))
        for of in (acus, acus.Client, acus.Server, acus.Run, acus.Track, acus.Scene, rotation, env, env.NeedleEnv, study, acus.Study,
                   study.World, study.Result, acus.plan, acus.plan.Plans, acus.plan.Plan,
                   acus.plan.Steering, acus.plan.Implant, acus.plan.Cloud, acus.fit, acus.fit.Fit, acus.fit.Fitted,
                   acus.fit.Measurement, acus.fit.Prediction):
            names = set(public_names(of)) - {"np", "close"}
            self.assertEqual(names - words, set(), of.__name__)


class Rotations(unittest.TestCase):
    def test_they_agree_with_each_other(self):
        random = np.random.default_rng(1)
        p, q, v = random.normal(size=4), random.normal(size=4), random.normal(size=3)
        p, q = p / np.linalg.norm(p), q / np.linalg.norm(q)
        np.testing.assert_allclose(rotation.rotate(rotation.multiply(p, q), v),
                                   rotation.rotate(p, rotation.rotate(q, v)), atol=1e-14)
        np.testing.assert_allclose(rotation.rotate(rotation.conjugate(q), rotation.rotate(q, v)), v, atol=1e-14)
        np.testing.assert_allclose(rotation.axis_of(q), rotation.rotate(q, [1, 0, 0]), atol=1e-14)
        np.testing.assert_allclose(rotation.rotate(rotation.rotation_about([0, 0, 3], np.pi / 2), [1, 0, 0]), [0, 1, 0],
                                   atol=1e-15)
        for direction in (v, [0, 0, -2], [-1, 0, 0], [1, 0, 0]):
            found = rotation.axis_of(rotation.orientation_along(direction))
            np.testing.assert_allclose(found, direction / np.linalg.norm(direction), atol=1e-14)
        self.assertRaises(ValueError, rotation.orientation_along, [0, 0, 0])
        self.assertRaises(ValueError, rotation.rotation_about, [0, 0, 0], 1)


if __name__ == "__main__":
    unittest.main()
