# SPDX-License-Identifier: MIT
"""Takes the project's scenes, and the meshes that they use, into the package: pip install client/python, from a checkout."""

import atexit
import os
import shutil
import tempfile

from setuptools import setup
from setuptools.command.build_py import build_py

SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes")


class WithScenes(build_py):
    def run(self):
        super().run()
        target = os.path.join(self.build_lib, "acus", "scenes")
        for folder, ending in (("", ".yaml"), ("meshes", ".msh"), ("trajectories", ".csv")):
            os.makedirs(os.path.join(target, folder), exist_ok=True)
            for name in sorted(os.listdir(os.path.join(SCENES, folder))):
                if name.endswith(ending):
                    shutil.copyfile(os.path.join(SCENES, folder, name), os.path.join(target, folder, name))


MADE = tempfile.mkdtemp(prefix="acus-pip-")  # what setuptools makes on the way: nothing is left in the checkout
atexit.register(shutil.rmtree, MADE, ignore_errors=True)
setup(cmdclass={"build_py": WithScenes}, options={"build": {"build_base": MADE}, "egg_info": {"egg_base": MADE}})
