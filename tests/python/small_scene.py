# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of the package share: where it is, and a scene that costs little."""

import os
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "client", "python"))

PATIENCE = 60  # s, for what takes milliseconds on a machine that is not busy

SCENE = """\
acus_scene: 1
name: {name}
rate: 200
tissue:
  mesh:
    box: {{size: [0.1, 0.1, 0.1], cells: [3, 3, 3]}}
  regions:
    - {{name: gel, interaction: {{puncture_force: 0.5}}}}
  fixed:
    - box: {{max: [.inf, .inf, -0.05]}}
needles:
  - name: left
    length: 0.1
    beams: 5
    base: {{position: [0.003, 0.002, 0.16], orientation: [0.7071068, 0, 0.7071068, 0]}}
  - name: right
    length: 0.1
    beams: 5
    base: {{position: [0.03, 0, 0.16], orientation: [0.7071068, 0, 0.7071068, 0]}}
guides:
  - {{name: hole, needle: left, pose: {{position: [0.003, 0.002, 0.055], orientation: [0.7071068, 0, 0.7071068, 0]}}}}
"""


class InTemporaryFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="acus-test-")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def write(self, name, text):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)

    def write_scene(self, name="small"):
        return self.write(name + ".yaml", SCENE.format(name=name))


def set_up_for_class(test_class, made):
    """An InTemporaryFolder whose folder is there for all tests of a class."""
    made.setUp()
    test_class.addClassCleanup(made.doCleanups)
    return made
