#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.Scene: what is read, edited and written is what the programs read."""

import glob
import math
import os
import subprocess
import unittest

import numpy as np

from small_scene import PATIENCE, ROOT, InTemporaryFolder

import acus  # noqa: E402
from acus.programs import find_server  # noqa: E402

SCENES = os.path.join(ROOT, "scenes")


class Reading(InTemporaryFolder):
    def test_every_scene_comes_back_the_same_from_its_text(self):
        for path in sorted(glob.glob(os.path.join(SCENES, "*.yaml"))):
            scene = acus.Scene.read(path)
            scene.save(self.path("again.yaml"))
            again = acus.Scene.read(self.path("again.yaml"))
            if "tissue.mesh.gmsh.file" in scene:  # the whole path now
                scene["tissue.mesh.gmsh.file"] = os.path.join(SCENES, scene["tissue.mesh.gmsh.file"])
            self.assertEqual(again.fields, scene.fields, path)

    def test_a_file_that_was_edited_is_replaced_only_where_that_is_said(self):
        path = self.write_scene()
        scene = acus.Scene.read(path)
        self.assertRaisesRegex(acus.SceneError, "small.yaml: something else stands there, .* replace=True", scene.save, path)
        scene.save(path, replace=True)
        scene["rate"] = 500
        scene.save(path)
        self.assertEqual(acus.Scene.read(path)["rate"], 500)

    def test_fields_are_named_as_in_messages(self):
        scene = acus.Scene.read(os.path.join(SCENES, "brachytherapy.yaml"))
        self.assertEqual(scene["needles[3].length"], 0.15)
        self.assertEqual(scene["needles[needle 6].base.position"], [0.006, 0.002, 0.2])
        self.assertEqual(scene["tissue.regions[prostate].material.young_modulus"], 30e3)
        self.assertEqual(scene["tissue.fixed[0].box.max[0]"], math.inf)
        self.assertEqual(scene["needles[0].material.young_modulus"], 200e9)  # the default
        self.assertNotIn("needles[0].material.young_modulus", scene)
        self.assertIn("needles[0].base", scene)
        for place, expected in (("needles[9].length", "no such entry"), ("needles[nobody].length", "no such entry"),
                                ("tissue.colour", "no such field"), ("needles..length", "expected the place"),
                                ("", "expected the place"), ("rate[0]", "no such field"),
                                ("needles[0].curved_length", "no default")):
            self.assertRaisesRegex(acus.SceneError, expected, lambda at=place: scene[at])

    def test_what_cannot_be_read_is_told(self):
        self.assertRaisesRegex(acus.SceneError, "No such file", acus.Scene.read, self.path("none.yaml"))
        self.assertRaisesRegex(acus.SceneError, r"bad.yaml:2:7: rate: expected a number", acus.Scene.read,
                               self.write("bad.yaml", "acus_scene: 1\nrate: fast\n"))


class Building(InTemporaryFolder):
    def build(self):
        scene = acus.Scene({"name": "built: by hand", "rate": 100})
        scene["tissue.mesh.box.cells"] = np.array([3, 3, 3])
        scene["tissue.fixed"] = [{"box": {"max": [math.inf, math.inf, -0.05]}}]
        place = scene.add("tissue.regions", {"name": "gel"})
        scene[place + ".material.young_modulus"] = np.float64(15e3)
        scene["tissue.regions[gel].interaction"] = {"puncture_force": math.inf}
        scene.add("needles", {"name": "7", "length": 0.1, "beams": 5, "base": {"position": [0, 0, 0.5]}})
        return scene.check()

    def test_a_scene_is_built_checked_and_sent_as_text(self):
        scene = self.build()
        with acus.Server(scene, lockstep=True) as server, server.client(timeout=PATIENCE) as client:
            self.assertEqual((client.hello.scene, client.needles[0].name), ("built: by hand", "7"))
            other = scene.copy()
            other["name"] = "another"
            client.load(other)
            self.assertEqual(client.hello.scene, "another")
        self.assertEqual(scene["name"], "built: by hand")

    def test_what_the_server_could_not_use_is_told_with_its_place(self):
        for place, value, expected in (
                ("rate", -1, "rate: expected"), ("tissue.regions[gel].colour", "red", "colour"),
                ("tissue.regions[0].material.poisson_ratio", 0.7, r"tissue.regions\[0\].material.poisson_ratio"),
                ("needles[0].length", "long", r"needles\[0\].length"), ("acus_scene", 2, "acus_scene")):
            scene = self.build()
            scene[place] = value
            with self.assertRaisesRegex(acus.SceneError, "^scene:.*" + expected):
                scene.check()
        scene = self.build()
        self.assertRaisesRegex(acus.SceneError, "no such entry", scene.__setitem__, "needles[1].length", 0.1)
        self.assertRaisesRegex(acus.SceneError, "no list", scene.__setitem__, "rate[1]", 0.1)
        scene["name"] = object()
        self.assertRaisesRegex(acus.SceneError, "expected numbers, texts", scene.check)

    def test_meshes_are_found_where_the_scene_was(self):
        scene = acus.Scene.read(os.path.join(SCENES, "inclusion_soft_needle.yaml"))
        scene["name"] = "elsewhere"
        with acus.Server(scene, lockstep=True) as server, server.client(timeout=PATIENCE) as client:
            self.assertGreater(client.hello.tissue.nodes, 100)
            client.load(scene)
            self.assertEqual(client.hello.scene, "elsewhere")

    def test_the_schema_is_that_of_the_program(self):
        shown = subprocess.run([find_server(), "--schema"], capture_output=True, text=True, check=True)
        self.assertIn(acus.Scene.schema()["title"], shown.stdout)
        self.assertEqual(acus.Scene.schema()["properties"]["rate"]["default"], 1000)


if __name__ == "__main__":
    unittest.main()
