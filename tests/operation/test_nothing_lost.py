# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways to lose a byte of somebody's file to a program of Acus, each tried: the file stays, and the program says what to do.
That a viewer's recording stays: tests/view/test_gateway.py. Studies, plans, fits and scenes: tests/python/."""

import os
import subprocess
import unittest

from running_server import PATIENCE, PROGRAMS, SCENE, WithServer

CLIENT = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "client")
MINE = "mine, of days\n"
MOTION = "t,needle,x,y,z,qw,qx,qy,qz\n0,left,0,0,0.5,1,0,0,0\n0.1,left,0,0,0.49,1,0,0,0\n"


class NothingLost(WithServer):
    def setUp(self):
        super().setUp()
        self.write("motion.csv", MOTION)
        done = self.run_program("acus-server", "--ticks", "40", "--record", self.path("run.acus"), *self.endpoints(), self.scene)
        self.assertEqual(done.returncode, 0, done.stderr)

    def endpoints(self):
        return ["--commands", self.commands, "--states", self.states]

    def run_program(self, name, *arguments, **settings):
        program = os.path.join(CLIENT, name) if name in ("plot", "picture") else os.path.join(PROGRAMS, name)
        return subprocess.run([program, *arguments], capture_output=True, text=True, check=False, timeout=PATIENCE, cwd=self.folder, **settings)

    def assert_kept(self, kept, name, *arguments, text=MINE):
        """The program refuses to run, with the file's name, which holds what it held."""
        with self.subTest(kept=kept, program=name, arguments=arguments):
            if text is not None:
                os.makedirs(os.path.dirname(self.path(kept)), exist_ok=True)
                self.write(kept, text)
            with open(self.path(kept), "rb") as file:
                before = file.read()
            done = self.run_program(name, *arguments)
            self.assertNotEqual(done.returncode, 0, done.stdout)
            self.assertIn(os.path.basename(os.path.dirname(self.path(kept)) if "/" in kept else kept), done.stderr)
            with open(self.path(kept), "rb") as file:
                self.assertEqual(file.read(), before)
            if text is not None:
                os.remove(self.path(kept))

    def test_exports(self):
        for kept, *arguments in (("mine.csv", "--csv", "mine.csv"), ("mine.events.csv", "--csv", "mine.csv"),
                                 ("mine.shapes", "--shapes", "mine.shapes"), ("mine.messages", "--messages", "mine.messages"),
                                 ("frames/mine.vtu", "--vtk", "frames")):
            self.assert_kept(kept, "acus-export", "run.acus", *arguments)
        for option in ("--csv", "--shapes", "--messages"):
            self.assert_kept("run.acus", "acus-export", "run.acus", option, "run.acus", text=None)

    def test_replays(self):
        for kept, *arguments in (("mine.csv", "--out", "mine.csv"), ("mine.events.csv", "--out", "mine.csv"),
                                 ("mine.shapes", "--shapes", "mine.shapes"), ("mine.csv", "--timing", "mine.csv"),
                                 ("mine.stats.csv", "--timing", "mine.csv"), ("mine.json", "--summary", "mine.json")):
            self.assert_kept(kept, "acus-replay", "motion.csv", *self.endpoints(), *arguments)
        self.assert_kept("motion.csv", "acus-replay", "motion.csv", "--out", "motion.csv", text=MOTION)

    def test_sessions_of_devices(self):
        for kept, *arguments in (("mine.csv", "--record", "mine.csv"), ("mine.json", "--summary", "mine.json")):
            self.assert_kept(kept, "acus-haptic", *self.endpoints(), *arguments)

    def test_servers(self):
        for kept, *arguments in (("mine.acus", "--record", "mine.acus"), ("mine", "--snapshot", "mine"), ("mine.new", "--snapshot", "mine"),
                                 ("scene.yaml", "--snapshot", "scene.yaml")):
            text = SCENE.format(name="small") if kept == "scene.yaml" else MINE
            self.assert_kept(kept, "acus-server", "--ticks", "1", *self.endpoints(), *arguments, "scene.yaml", text=text)
            self.write("scene.yaml", SCENE.format(name="small"))
        self.assert_kept("run.acus", "acus-server", "--ticks", "1", *self.endpoints(), "--record", "run.acus", "scene.yaml", text=None)

    def test_keys_and_films(self):
        for kept in ("mine.key", "mine.key_secret"):
            self.assert_kept(kept, "acus-keygen", "mine")
        self.assertEqual([name for name in os.listdir(self.folder) if "key" in name], [])
        for kept, target in (("mine.mp4", "mine.mp4"), ("film/000001.png", "film")):
            self.assert_kept(kept, "acus-view", "run.acus", "--no-browser", "--export", target)

    def test_plots(self):
        self.assertEqual(self.run_program("acus-export", "run.acus", "--csv", "run.csv", "--shapes", "run.shapes").returncode, 0)
        self.assert_kept("mine.svg", "plot", "run.csv", "--out", "mine.svg")
        self.assert_kept("run.png", "plot", "run.csv")

    def test_a_second_run_replaces_the_files_of_the_first(self):
        arguments = ("run.acus", "--csv", "run.csv", "--shapes", "run.shapes", "--messages", "run.messages")
        for _ in range(2):
            self.assertEqual(self.run_program("acus-export", *arguments).returncode, 0)
            self.assertEqual(self.run_program("acus-server", "--ticks", "1", *self.endpoints(), "--snapshot", "kept", self.scene).returncode, 0)


if __name__ == "__main__":
    unittest.main()
