# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of studies share: a small scene, and studies of it in a folder of their own."""

import unittest

from small_scene import SCENE, InTemporaryFolder

import acus  # noqa: E402
from acus import engine  # noqa: E402

STIFFNESS = "tissue.regions[0].material.young_modulus"
PUNCTURE = "tissue.regions[gel].interaction.puncture_force"
PUSH = acus.Insertion(depth=0.03, speed=0.2)


@unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
class OfStudies(InTemporaryFolder):
    def setUp(self):
        super().setUp()
        self.scene = acus.Scene.read(self.write("small.yaml", SCENE.format(name="small")))

    def study(self, parameters=None, motion=PUSH, outputs=("peak_force", "tip"), folder="study", **settings):
        return acus.Study(self.scene, motion, parameters or {STIFFNESS: [5e3, 10e3], "motion.tilt": [0.0, 0.1]}, outputs,
                          folder=self.path(folder), **settings)

    def run_study(self, *arguments, run=None, **settings):
        """In this process, unless `run` says otherwise."""
        return self.study(*arguments, **settings).run(progress=False, **{"workers": 0, **(run or {})})
