#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.engine: the simulation in this process does what a server does, bit by bit."""

import signal
import subprocess
import threading
import unittest

import numpy as np

from small_scene import InTemporaryFolder

import acus  # noqa: E402
from acus import engine  # noqa: E402

TICKS = 300


def push(model, tick):
    """The command of a needle that goes in along its axis at 20 mm/s."""
    needle = model.needles[0]
    return {needle.name: (needle.base_position + 0.02 * tick / model.rate * needle.axis, needle.base_orientation, 0.1 * tick)}


def pushed(model, ticks=TICKS):
    state = model.start()
    reports = [engine.step(model, state, push(model, tick)) for tick in range(1, ticks + 1)]
    return state, reports


@unittest.skipUnless(engine.available(), "SKIPPED: the engine is not built as a Python module (pybind11 is missing)")
class Engine(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.path = acus.find_scene("insertion_pullback")
        cls.model = engine.load(cls.path)


class Runs(Engine):
    def test_a_server_gives_the_same_bytes(self):
        state, reports = pushed(self.model, 1200)
        with acus.Server(self.path, lockstep=True) as server, server.client(topics=("force", "event")) as client:
            needle = client.needles[0]
            client.acquire(needle)
            events = []
            for tick, report in enumerate(reports, 1):
                client.pose(needle, *push(self.model, tick)["needle"])
                states = client.step(1)
                events += states.events
                ours, theirs = report["needle"], states["needle"]
                for name in ("tip_position", "base_force", "base_force_in_base", "commanded_orientation", "friction_force"):
                    np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name), name)
                self.assertEqual((ours.tick, ours.phase, ours.depth, ours.seq), (theirs.tick, theirs.phase, theirs.depth, theirs.seq))
            self.assertEqual(client.hash().hash, state.hash)
            snapshot = client.snapshot().snapshot
            self.assertEqual(self.model.state(snapshot), state)
            client.restore(state.bytes())
            self.assertEqual(client.hash().hash, state.hash)
        own = [event for report in reports for event in report.events]
        self.assertEqual([(event.kind, event.tick, event.region, event.force) for event in own],
                         [(event.kind, event.tick, event.region, event.force) for event in events])
        self.assertIn("puncture", [event.kind for event in own])

    def test_many_ticks_at_once_are_the_same_and_a_trace_has_each(self):
        state, reports = pushed(self.model, 5)
        at_once, traced = self.model.start(), self.model.start()
        engine.step(self.model, at_once, push(self.model, 1), ticks=5)
        trace = traced.trace(push(self.model, 1), 5)
        self.assertEqual(at_once, traced)
        self.assertNotEqual(at_once, state)  # it was told once
        self.assertEqual([report.tick for report in trace], [1, 2, 3, 4, 5])
        np.testing.assert_array_equal(trace[0]["needle"].base_position, reports[0]["needle"].base_position)

    def test_threads_step_states_of_one_model(self):
        alone, _ = pushed(self.model)
        found = [None] * 4

        def run(i):
            found[i] = pushed(self.model)[0].hash

        threads = [threading.Thread(target=run, args=(i,)) for i in range(len(found))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(found, [alone.hash] * len(found))

    def test_long_work_can_be_interrupted(self):
        state = self.model.start()
        threading.Timer(0.3, signal.raise_signal, [signal.SIGINT]).start()
        self.assertRaises(KeyboardInterrupt, engine.step, self.model, state, {}, 10**9)
        tick = state.tick
        self.assertGreater(tick, 0)
        engine.step(self.model, state)
        self.assertEqual(state.tick, tick + 1)

    def test_a_state_that_a_thread_steps_is_not_to_be_read(self):
        state, refused = self.model.start(), []

        def look():
            for read in (lambda: state.hash, state.bytes, state.copy, lambda: state == state, lambda: state.paths,
                         lambda: state.step({}), lambda: state.report):
                try:
                    read()
                except RuntimeError as error:
                    refused.append(str(error))
            signal.raise_signal(signal.SIGINT)

        threading.Timer(0.3, look).start()
        self.assertRaises(KeyboardInterrupt, engine.step, self.model, state, {}, 10**9)
        self.assertEqual(len(refused), 7)
        self.assertIn("another thread steps this state", refused[0])
        self.assertGreater(state.hash, 0)

    def test_a_mesh_file_is_read(self):
        model = engine.load(acus.find_scene("brachytherapy"))
        self.assertEqual(len(model.needles), 6)
        self.assertGreater(len(model.tetrahedra), 1000)


class Values(Engine):
    def test_a_copy_is_another_state(self):
        state, _ = pushed(self.model, 20)
        copy, read = state.copy(), self.model.state(state.bytes())
        self.assertTrue(copy == state == read)
        self.assertEqual(copy.hash, state.hash)
        engine.step(self.model, state, push(self.model, 21))
        self.assertNotEqual(copy, state)
        self.assertEqual((copy.tick, state.tick), (20, 21))
        for other in (copy, read):
            engine.step(self.model, other, push(self.model, 21))
            self.assertEqual(other, state)

    def test_arrays_are_views_that_cannot_be_written(self):
        state = self.model.start()
        tissue, needle = state.tissue_positions, state.needle_positions("needle")
        before = needle.copy()
        self.assertEqual(tissue.shape, self.model.rest_positions.shape)
        engine.step(self.model, state, push(self.model, 1000), ticks=200)
        self.assertTrue(np.shares_memory(tissue, state.tissue_positions))
        self.assertGreater(np.abs(needle - before).max(), 1e-3)  # it shows what is now
        for array in (tissue, needle, self.model.rest_positions, self.model.tetrahedra):
            self.assertRaises(ValueError, array.__setitem__, (0, 0), 1)
        del state
        self.assertTrue(np.isfinite(tissue).all())  # which keeps what it shows
        np.testing.assert_allclose(np.linalg.norm(self.model.start().needle_orientations("needle"), axis=1), 1)

    def test_paths_lead_to_the_tip(self):
        state, reports = pushed(self.model, 1200)
        (path,) = state.paths
        self.assertLess(np.linalg.norm(path[-1] - reports[-1]["needle"].tip_position), 1e-6)

    def test_a_tip_that_presses_is_on_the_drawn_skin(self):
        state, force, tick = self.model.start(), 0, 0
        while force < 0.1:
            tick += 1
            force = -engine.step(self.model, state, push(self.model, tick))["needle"].base_force_in_base[0]
        dents, tip = acus.Dents(*state.dents), state.needle_positions("needle")[-1]
        self.assertEqual(len(dents), 1)
        np.testing.assert_allclose(dents.displaced(dents.centres[0]), tip, atol=1e-9)
        self.assertGreater(np.linalg.norm(dents.moves[0]), 1e-4)


class Adoption(Engine):
    def other(self, **fields):
        scene = acus.Scene.read(self.path)
        for place, value in fields.items():
            scene[place] = value
        return engine.load(scene)

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.pushed, _ = pushed(cls.model, 700)

    def test_where_nothing_differs_the_bits_go_on(self):
        state = self.pushed.copy()
        other = self.other()
        adopted = other.adopt(state)
        self.assertEqual(adopted.hash, state.hash)
        for model, each in ((self.model, state), (other, adopted)):
            engine.step(model, each, push(self.model, 800), ticks=50)
        self.assertEqual(adopted.hash, state.hash)

    def test_time_goes_on_at_another_rate(self):
        state = self.pushed.copy()
        engine.step(self.model, state, push(self.model, 703), ticks=3)
        slow = self.other(rate=50)
        adopted = slow.adopt(state)
        self.assertAlmostEqual(adopted.time, state.time, delta=0.01)
        for tick in range(710, 810, 10):
            last = engine.step(slow, adopted, push(self.model, tick))["needle"]
            for each in range(tick - 9, tick + 1):
                report = engine.step(self.model, state, push(self.model, each))["needle"]
        np.testing.assert_allclose(last.tip_position, report.tip_position, atol=3e-4)  # m, of them 0.02 of a tick's way
        np.testing.assert_allclose(last.base_force, report.base_force, atol=0.03 * np.linalg.norm(report.base_force))

    def test_from_a_window_into_none_but_not_back(self):
        windowed = self.other(**{"tissue.window": 8})
        state, _ = pushed(windowed, 700)
        adopted = self.model.adopt(state)
        np.testing.assert_array_equal(adopted.tissue_positions, state.tissue_positions)
        for tick in range(701, 801):
            whole = engine.step(self.model, adopted, push(self.model, tick))["needle"]
            report = engine.step(windowed, state, push(self.model, tick))["needle"]
        np.testing.assert_allclose(report.tip_position, whole.tip_position, atol=2e-5)
        np.testing.assert_allclose(report.base_force, whole.base_force, atol=0.005 * np.linalg.norm(whole.base_force))
        with self.assertRaisesRegex(ValueError, "tissue.window: 0"):
            windowed.adopt(self.pushed)

    def test_other_numbers_count_from_then_on(self):
        state = self.pushed.copy()
        scene = acus.Scene.read(self.path)
        softer = self.other(**{"tissue.regions[0].material.young_modulus": 0.5 * scene["tissue.regions[0].material.young_modulus"]})
        adopted, all_along = softer.adopt(state), pushed(softer, 700)[0]
        np.testing.assert_array_equal(adopted.tissue_positions, state.tissue_positions)
        forces = []
        for model, each in ((softer, adopted), (softer, all_along), (self.model, state)):
            for tick in range(701, 1201):  # 20 mm, after which the tissue has been dragged along as far
                report = engine.step(model, each, push(self.model, tick))
            forces.append(report["needle"].base_force[2])
        self.assertAlmostEqual(forces[0], forces[1], delta=0.005 * forces[1])
        self.assertGreater(forces[2], 1.04 * forces[1])

    def test_more_than_numbers_is_refused(self):
        state = self.model.start()
        scene = acus.Scene.read(self.path)
        for fields, what in (({"needles[0].beams": 7}, "beams of 'needle'"), ({"needles[0].length": 0.14}, "length"), ({"needles[0].name": "other"}, "names of needles"),
                             ({"tissue.mesh.box.cells": [5, 5, 5]}, "another mesh")):
            self.assertRaisesRegex(ValueError, what, self.other(**fields).adopt, state)
        self.assertRaises(TypeError, self.model.adopt, b"bytes")


class Placement(Engine):
    def test_a_needle_elsewhere_is_as_if_the_scene_had_it_there(self):
        scene, needle = acus.Scene.read(self.path), self.model.needles[0]
        scene["needles[0].base.position"] = needle.base_position + [0.01, 0.005, 0.02]
        there = engine.load(scene)
        other, placed = there.start(), self.model.start({"needle": (there.needles[0].base_position, needle.base_orientation)})
        for tick in range(100):
            engine.step(there, other, push(there, 60 * tick))
            engine.step(self.model, placed, push(there, 60 * tick))
        self.assertEqual(placed.hash, other.hash)

    def test_guides_can_be_elsewhere(self):
        scene = acus.Scene.read(acus.find_scene("steering"))
        model = engine.load(scene)
        guide = model.guides[0]
        position = guide.position + [0, 0, 1e-3]
        scene[f"guides[{guide.name}].pose.position"] = position
        moved, placed = engine.load(scene), model.start({guide.name: (position, guide.orientation)})
        state = moved.start()
        engine.step(moved, state, ticks=20)
        engine.step(model, placed, ticks=20)
        self.assertEqual(placed.hash, state.hash)

    def test_where_scenes_start_in_equilibrium_needles_elsewhere_are_in_it_too(self):
        scene, needle = acus.Scene.read(self.path), self.model.needles[0]
        scene["gravity"], scene["start"] = [0, 3, -9.81], "equilibrium"
        scene["tissue.regions[0].material.young_modulus"] = 5e3
        model = engine.load(scene)
        position = needle.base_position + [0.01, 0.005, 0.02]
        state = model.start({"needle": (position, needle.base_orientation)})
        self.assertGreater(np.abs(state.tissue_positions - model.rest_positions).max(), 1e-3)
        tissue, shaft = state.tissue_positions, state.needle_positions("needle")
        report = engine.step(model, state, ticks=100)
        self.assertEqual(report.flags, 0)
        np.testing.assert_allclose(state.tissue_positions, tissue, atol=1e-7, rtol=0)
        np.testing.assert_allclose(state.needle_positions("needle"), shaft, atol=1e-8, rtol=0)

    def test_a_place_that_cannot_be_is_refused(self):
        needle = self.model.needles[0]
        for body, what in ((("needle", needle.base_position - [0, 0, 0.05]), "tip outside the tissue"),
                           (("other", needle.base_position), "no needle or guide 'other'"),
                           (("needle", [np.nan, 0, 0]), "not finite")):
            self.assertRaisesRegex((ValueError, KeyError), what, self.model.start, {body[0]: (body[1], needle.base_orientation)})
        self.assertRaisesRegex(ValueError, "expected \\(position, orientation\\)", self.model.start,
                               {"needle": (needle.base_position, needle.base_orientation, 1.0)})


class Recordings(InTemporaryFolder, Engine):
    def export(self, path):
        done = subprocess.run([acus.programs.find_program("acus-export"), path, "--csv", self.path_of_csv], text=True,
                              capture_output=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def setUp(self):
        super().setUp()
        self.path_of_csv = self.folder + "/run.csv"

    def test_a_recording_is_one_of_a_server(self):
        needle, recording = self.model.needles[0], self.folder + "/run.acus"
        away = needle.base_position + [0.01, 0, 0]
        state = self.model.start({"needle": (away, needle.base_orientation)})
        state.record(recording)
        reports = []
        for tick in range(1, 700):
            command = {"needle": (away + 8e-5 * tick * needle.axis, needle.base_orientation, 0.01 * tick)} if tick % 3 else {}
            reports.append(engine.step(self.model, state, command))
        copy = state.copy()
        engine.step(self.model, copy, ticks=50)  # is not recorded
        self.assertRaisesRegex(OSError, "recorded already", state.record, self.folder + "/other.acus")
        state.end_recording()
        state.end_recording()
        engine.step(self.model, state, ticks=50)
        self.assertIn("699 ticks", found := self.export(recording))
        self.assertIn("the same to the last bit", found)
        with acus.Run(self.path_of_csv) as run:
            np.testing.assert_allclose(run["needle"].base_force, [report["needle"].base_force for report in reports], atol=1e-12)
            self.assertIn("puncture", [event.kind for event in run.events])

    def test_it_ends_with_the_state(self):
        state = engine.load(acus.find_scene("brachytherapy")).start()  # whose mesh is in the recording
        recording = self.folder + "/run.acus"
        state.record(recording)
        state.step({}, 5)
        del state
        self.assertIn("5 ticks", self.export(recording))

    def test_where_it_cannot_be_written(self):
        state = self.model.start()
        self.assertRaisesRegex(OSError, "No such file", state.record, "/nowhere/run.acus")
        state.record(self.folder + "/run.acus")
        self.assertRaisesRegex(OSError, "a file of this name already", self.model.start().record, self.folder + "/run.acus")


class Errors(InTemporaryFolder, Engine):
    def test_scenes(self):
        self.assertRaisesRegex(acus.SceneError, "rate", engine.load, "acus_scene: 1\nrate: fast\n")
        self.assertRaisesRegex(acus.SceneError, "nowhere", engine.load, "nowhere.yaml")
        self.assertEqual(engine.load(acus.Scene({"name": "own", "tissue": {"rung": "none"}})).name, "own")

    def test_commands(self):
        state, needle = self.model.start(), self.model.needles[0]
        here = (needle.base_position, needle.base_orientation)
        for commands, what in (({"other": here}, "no needle or guide 'other'"), ({"needle": here[:1]}, "expected \\(position"),
                               ({"needle": (here[0], [1, 1, 0, 0])}, "unit quaternion"), ({"needle": ([1, 2], here[1])}, "3 numbers"),
                               ({"needle": ([np.nan] * 3, here[1])}, "command of 'needle': .* not finite"),
                               ({"needle": (None, here[1])}, "go together"), ({"needle": (*here, "fast")}, "spin: expected a number"),
                               ({"needle": "ab"}, "position of 'needle'"), ({5: here}, "no needle or guide '5'")):
            with self.subTest(what=what):
                self.assertRaisesRegex((ValueError, KeyError), what, engine.step, self.model, state, commands)
        self.assertRaisesRegex(ValueError, "at least 1", engine.step, self.model, state, {}, 0)
        self.assertRaisesRegex(KeyError, "no needle 'other'", lambda: state.report["other"])
        self.assertRaises(TypeError, engine.step, self.model, state, {}, 1.5)
        self.assertRaisesRegex(TypeError, "Model.start", engine.step, self.model, 5)
        self.assertEqual(state.tick, 0)  # nothing has happened
        engine.step(self.model, state, {"needle": (None, None, 0.5)})
        for error in (1e-6, 1e-5, 5e-4):  # normalised, as a server does
            engine.step(self.model, state, {"needle": (here[0], np.array(here[1]) * (1 + error))})

    def test_states(self):
        other = engine.load("acus_scene: 1\ntissue: {rung: none}\n")
        self.assertRaisesRegex(ValueError, "another model", engine.step, other, self.model.start())
        for damaged in (b"", b"nonsense", self.model.start().bytes()[:-1], other.start().bytes()):
            self.assertRaises(ValueError, self.model.state, damaged)
        self.assertNotEqual(self.model.start(), other.start())
        self.assertEqual(self.model.start(), engine.load(self.path).start())
        self.assertFalse(self.model.start() == 5)
        self.assertRaisesRegex(TypeError, "expected bytes", self.model.state, "text")

    def test_there_are_no_empty_objects(self):
        report = engine.step(self.model, self.model.start())
        for one in (self.model.start(), self.model.start().model, report, report["needle"]):
            with self.subTest(kind=type(one).__name__):
                self.assertRaises(TypeError, type(one).__new__, type(one))
                self.assertRaises(TypeError, type(one))

    def test_needles_are_those_of_hello(self):
        for name in ("steering", "brachytherapy"):
            with acus.Server(acus.find_scene(name), lockstep=True) as server, server.client() as client:
                model = engine.load(acus.find_scene(name))
                self.assertEqual([str(each) for each in model.needles], [str(each) for each in client.needles])
                self.assertEqual([str(each) for each in model.guides], [str(each) for each in client.hello.guides])



@unittest.skipUnless(engine.available(), "without the engine")
class InWords(InTemporaryFolder):
    def test_what_objects_are_is_told(self):
        model = engine.load(acus.Scene.read("layers"))
        state = model.start()
        report = engine.step(model, state, ticks=3)
        self.assertEqual(repr(acus.Scene.read("layers")), "<Scene 'layers': 3 regions, 1 needle>")
        self.assertEqual(repr(acus.Scene()), "<Scene 'scene'>")
        self.assertEqual(repr(model), "<Model of 'layers': 1053 nodes, 3 regions, 1 needle, 500 Hz>")
        self.assertEqual(repr(state), "<State of 'layers': tick 3 (0.006 s)>")
        self.assertRegex(repr(report), r"^<Report of tick 3 \(0\.006 s\); needle: free, depth 0 mm, base force \S+ N; 0 events>$")

    def test_names_of_scenes_are_taken_where_files_are(self):
        self.assertEqual(engine.load("layers").name, "layers")
        self.assertEqual(engine.load(acus.find_scene("layers")).name, "layers")
        with acus.Server("layers", lockstep=True) as server, server.client() as client:
            self.assertEqual(client.hello.scene, "layers")
        for read in (engine.load, acus.Scene.read):
            self.assertRaisesRegex(acus.SceneError, "no scene 'nowhere': neither a file nor one of the project; there are biopsy", read, "nowhere")
            self.assertRaisesRegex(acus.SceneError, "nowhere.yaml", read, "nowhere.yaml")


if __name__ == "__main__":
    unittest.main()
