#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""acus.study: the same rows on any number of workers, none lost and none twice, whatever ends them."""

import csv
import dataclasses
import io
import math
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import threading
import time
import unittest

import numpy as np

from of_studies import PUNCTURE, PUSH, STIFFNESS, OfStudies
from small_scene import PATIENCE, ROOT, SCENE

import acus  # noqa: E402
from acus import engine, study  # noqa: E402
from acus.study.progress import Progress  # noqa: E402


# ---- Rows ----


class Rows(OfStudies):
    def test_a_row_for_each_case_and_the_same_on_any_number_of_workers(self):
        one, two = (self.run_study(folder=str(n), run={"workers": n}) for n in (1, 2))
        self.assertEqual([row["case"] for row in one.rows], [0, 1, 2, 3])
        self.assertEqual([(row[STIFFNESS], row["motion.tilt"]) for row in one.rows],
                         [(5e3, 0.0), (5e3, 0.1), (10e3, 0.0), (10e3, 0.1)])
        self.assertEqual(one.digest, two.digest)
        self.assertEqual([row["hash"] for row in one.rows], [row["hash"] for row in two.rows])
        self.assertEqual(len({row["hash"] for row in one.rows}), 4)
        for row in one.rows:
            self.assertEqual((row["error"], row["flags"], row["ticks"]), ("", "", 31))
            self.assertTrue(0 < row["tick_p50"] <= row["tick_p99"] < row["wall_time"] and 0 < row["calibration"] < 1, row)
            self.assertTrue(row["processor"] and row["version"] and row["seed"] > 0)

    def test_the_engine_alone_gives_the_same(self):
        row = self.run_study({STIFFNESS: [8e3]}).rows[0]
        scene = self.scene.copy()
        scene[STIFFNESS] = 8e3
        model = engine.load(scene)
        state, needle = model.start(), model.needles[0]
        forces = []
        for tick in range(1, 32):  # one to come to rest
            position = needle.base_position + 0.03 * tick / 30 * needle.axis
            commands = {"left": (position, needle.base_orientation)} if tick <= 30 else {}
            forces.append(engine.step(model, state, commands)["left"].base_force @ -needle.axis)
        self.assertEqual(row["hash"], f"{state.hash:016x}")
        self.assertAlmostEqual(row["peak_force"], max(forces), 12)

    def test_a_second_run_does_what_is_missing(self):
        first = self.run_study({STIFFNESS: [5e3, 10e3]})
        before = {row[STIFFNESS]: row for row in first.rows}
        more = self.run_study({STIFFNESS: [2e3, 5e3, 10e3]})
        self.assertEqual([row[STIFFNESS] for row in more.rows], [2e3, 5e3, 10e3])
        for row in more.rows[1:]:  # with the times that were measured then
            self.assertEqual(row, {**before[row[STIFFNESS]], "case": row["case"]})
        self.assertEqual(len(self.lines()), 3)
        more.run(progress=False, workers=0)
        self.assertEqual(len(self.lines()), 3)

    def test_what_changes_a_result_runs_again(self):
        self.run_study({STIFFNESS: [5e3]})
        for settings in ({"outputs": ("end_force",)}, {"motion": dataclasses.replace(PUSH, depth=0.02)}, {"seed": 1},
                         {"outputs": {"x": lambda result: 1}}, {"outputs": {"x": lambda result: 2}}):
            before = len(self.lines())
            self.run_study({STIFFNESS: [5e3]}, **settings)
            self.assertEqual(len(self.lines()), before + 1, settings)

    def test_a_line_cut_in_the_middle_comes_again(self):
        whole = self.run_study({STIFFNESS: [5e3, 10e3]})
        path, digest = self.path("study", "rows.jsonl"), whole.digest
        for damage in (lambda data: data[:-40], lambda data: data[:-1], lambda data: b"\x00{]\n" + data, lambda data: b""):
            with open(path, "rb") as file:
                data = file.read()
            with open(path, "wb") as file:
                file.write(damage(data))
            self.assertEqual(self.run_study({STIFFNESS: [5e3, 10e3]}).digest, digest)

    def test_the_table_as_csv_and_as_frame(self):
        done = self.run_study(outputs=["peak_force", "tip", study.Distance((0, 0, 0.02))])
        with open(self.path("study", "table.csv"), newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(list(rows[0])[:8], ["case", STIFFNESS, "motion.tilt", "peak_force", "tip.x", "tip.y", "tip.z", "distance"])
        self.assertEqual([float(row["tip.z"]) for row in rows], [row["tip.z"] for row in done.rows])
        self.assertIn("4 have run, 0 of them failed", repr(done))
        try:
            import pandas  # noqa: F401  pylint: disable=import-outside-toplevel,unused-import
        except ImportError:
            self.assertRaisesRegex(acus.StudyError, "pandas", lambda: done.table)
            return
        self.assertEqual(list(done.table.columns), done.columns)
        self.assertEqual(done.table["peak_force"].tolist(), [row["peak_force"] for row in done.rows])
        try:
            import pyarrow  # noqa: F401  pylint: disable=import-outside-toplevel,unused-import
        except ImportError:
            self.assertRaisesRegex(acus.StudyError, "pyarrow", done.write, self.path("t.parquet"))
        else:
            done.write(self.path("t.parquet"))
            self.assertEqual(len(pandas.read_parquet(self.path("t.parquet"))), 4)

    def lines(self):
        with open(self.path("study", "rows.jsonl"), encoding="utf-8") as file:
            return file.readlines()


# ---- Failures ----


def breaks(result):
    if result.parameters[STIFFNESS] > 5e3:
        raise ValueError("too stiff")
    return 1.0


class Failures(OfStudies):
    def test_a_case_that_fails_keeps_error_and_recording(self):
        made = self.run_study({STIFFNESS: [5e3, 10e3]}, outputs={"fine": breaks})
        self.assertEqual([row["error"] for row in made.rows], ["", "ValueError: too stiff"])
        self.assertEqual(made.rows[0]["fine"], 1.0)
        with open(made.recording(1).replace(".acus", ".txt"), encoding="utf-8") as file:
            self.assertIn("in breaks", file.read())
        self.assertIsNone(made.recording(0))
        exported = subprocess.run([acus.programs.find_program("acus-export"), made.recording(1)], capture_output=True, text=True,
                                  check=False)
        self.assertEqual(exported.returncode, 0, exported.stderr)
        self.assertIn("31 ticks", exported.stdout)
        self.assertEqual(len(os.listdir(self.path("study", "cases"))), 2)

    def test_it_runs_again_alone_or_when_asked_to(self):
        made = self.run_study({STIFFNESS: [5e3, 10e3]}, outputs={"fine": breaks})
        result = made.case(1, recording=self.path("alone.acus"))
        self.assertEqual(result.state.tick, 31)
        self.assertRaisesRegex(ValueError, "too stiff", breaks, result)
        self.assertGreater(os.path.getsize(self.path("alone.acus")), 100)
        before = made.rows[1]["wall_time"]
        made.run(progress=False, workers=0)
        self.assertEqual(made.rows[1]["wall_time"], before)
        made.run(progress=False, workers=0, failed=True)
        self.assertNotEqual(made.rows[1]["wall_time"], before)

    def test_scenes_that_cannot_be(self):
        made = self.run_study({STIFFNESS: [5e3, -1.0], "motion.entry": [(0, 0, 0.05), (0, 0, 0.0)]})
        self.assertEqual([bool(row["error"]) for row in made.rows], [False, True, True, True])
        self.assertIn("tip outside the tissue", made.rows[1]["error"])
        self.assertIn("SceneError", made.rows[2]["error"])
        self.assertIn("young_modulus", made.rows[2]["error"])

    def test_a_motion_that_lets_no_error_out_ends_in_time(self):
        def stubborn(world):
            while True:
                try:
                    world.step(10)
                except Exception:  # pylint: disable=broad-except
                    pass

        made = self.run_study({"way": [1]}, motion=stubborn, run={"timeout": 0.3})
        self.assertEqual(made.rows[0]["error"], "TimeoutError: the case took longer than 0.3 s")

    def test_what_a_failed_case_has_told_is_no_value(self):
        made = self.run_study({STIFFNESS: [5e3, 10e3]}, outputs={"force": "peak_force", "fine": breaks})
        self.assertTrue(np.isfinite(made.values("force")[0]) and np.isnan(made.values("force")[1]))

    def test_a_recording_that_was_not_ended_is_made_again(self):
        made = self.run_study({STIFFNESS: [5e3]})
        part = self.path("study", "cases", made.keys[0] + ".acus.part")
        self.write(os.path.join("study", "cases", os.path.basename(part)), "half")
        made.run(progress=False, workers=0, recordings=True)
        self.assertFalse(os.path.exists(part))
        with acus.Run(made.recording(0)) as run:
            self.assertEqual(len(run["left"]), 31)
        before = made.rows[0]["wall_time"]
        made.run(progress=False, workers=0, recordings=True)
        self.assertEqual(made.rows[0]["wall_time"], before)

    def test_a_case_that_hangs_is_ended(self):
        def hangs(world):
            world.step()
            while world.parameters["way"] == "hang":
                time.sleep(0.01)

        made = self.run_study({"way": ["go", "hang", "go"]}, motion=hangs, run={"timeout": 0.5})
        self.assertEqual([row["error"] for row in made.rows], ["", "TimeoutError: the case took longer than 0.5 s", ""])

    def test_a_worker_that_dies_takes_no_other_case_with_it(self):
        ways = ["go", "go", "crash", "go", "crash", "go", "go", "go"]
        cases = study.table([{"motion.way": way, "motion.number": number} for number, way in enumerate(ways)])
        made = acus.Study(self.scene, Dying(), cases, {"ticks_made": lambda result: result.state.tick}, folder=self.path("study"))
        made.run(progress=False, workers=2)
        self.assertEqual([bool(row["error"]) for row in made.rows], [way == "crash" for way in ways])
        self.assertIn("the process died", made.rows[2]["error"])
        self.assertEqual(len(self.lines()), len(ways))

    def test_a_program_that_is_killed_loses_no_row_and_leaves_no_process(self):
        script = self.write("long.py", textwrap.dedent("""
            import sys
            sys.path.insert(0, sys.argv[1])
            import acus
            acus.Study(sys.argv[2], acus.Insertion(depth=0.03, speed=0.2), {"motion.tilt": [i * 1e-4 for i in range(400)]},
                       folder="long").run(workers=2, progress=False)
        """))
        path = self.write("small.yaml", SCENE.format(name="small"))
        process = subprocess.Popen([sys.executable, script, os.path.join(ROOT, "client", "python"), path], cwd=self.folder)
        rows = self.path("long", "rows.jsonl")
        self.wait_for(lambda: os.path.exists(rows) and len(lines_of(rows)) > 5)
        workers = children_of(process.pid)
        self.assertEqual(len(workers), 2)
        process.kill()
        process.wait()
        self.wait_for(lambda: not any(os.path.exists(f"/proc/{worker}") for worker in workers))
        kept = lines_of(rows)
        made = acus.Study(path, PUSH, {"motion.tilt": [i * 1e-4 for i in range(10)]}, folder=self.path("long"))
        self.assertGreater(len(made.rows), 5)
        made.run(progress=False, workers=0)
        self.assertEqual(lines_of(rows)[:len(kept)], kept)

    def test_two_programs_do_not_run_in_one_folder(self):
        made = self.study()
        with made._store:  # pylint: disable=protected-access
            self.assertRaisesRegex(acus.StudyError, "another program", self.study().run, progress=False)
        self.study().run(progress=False, workers=0)

    def test_an_interrupt_ends_it_at_once_and_keeps_rows(self):
        rows = self.path("study", "rows.jsonl")

        def slow(world):
            while world.parameters["number"] or not world.state.tick:
                world.step()
                if world.parameters["number"] == 1 and os.path.getsize(rows):
                    os.kill(os.getppid(), signal.SIGINT)
                    time.sleep(PATIENCE)

        made = self.study({"number": [0, 1, 2, 3]}, motion=slow)
        with self.assertRaises(KeyboardInterrupt):
            made.run(progress=False, workers=2)
        self.assertEqual([row["number"] for row in self.study({"number": [0, 1, 2, 3]}, motion=slow).rows], [0])

    def wait_for(self, condition):
        end = time.monotonic() + PATIENCE
        while not condition():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.02)

    def lines(self):
        return lines_of(self.path("study", "rows.jsonl"))


@dataclasses.dataclass(frozen=True)
class Dying:
    """Where it crashes, its worker is killed. `number` makes cases differ."""

    number: int = 0
    way: str = "go"

    def __call__(self, world):
        world.step(3)
        if self.way == "crash":
            os.kill(os.getpid(), signal.SIGKILL)


def lines_of(path):
    with open(path, encoding="utf-8") as file:
        return file.readlines()


def children_of(pid):
    with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as file:
        return [int(each) for each in file.read().split()]


# ---- acus-study ----


class Program(OfStudies):
    def run_program(self, *arguments):
        return subprocess.run([os.path.join(ROOT, "client", "study"), *arguments], capture_output=True, text=True, check=False,
                              cwd=self.folder)

    def test_show(self):
        self.run_study({STIFFNESS: [5e3, 10e3]}, outputs={"fine": breaks})
        done = self.run_program("show", "study")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout, "study: a grid of 2 cases, 2 have run in this folder, 1 failed\n"
                                      "  1 failed: ValueError: too stiff\n")
        self.assertEqual((self.run_program("show", "nowhere").returncode, self.run_program().returncode), (1, 1))

    def test_clusters_that_cannot_be(self):
        for arguments, status, what in ((("--local", "--workers", "0", "true"), 1, "whole number above 0"),
                                        (("--local", "--workers", "2"), 1, "expected a program"), (("--workers", "2", "true"), 1, "--slurm"),
                                        (("--local", "--workers", "2", "--option=x", "true"), 1, "is for --slurm")):
            done = self.run_program("cluster", *arguments)
            self.assertEqual(done.returncode, status, done.stderr)
            self.assertIn(what, done.stderr)
        self.assertEqual(os.listdir(self.folder), ["small.yaml"])


# ---- What users give ----


class Given(OfStudies):
    def test_parameters_that_are_none(self):
        for parameters, what in (({"needles[0].young_modulus": [1]}, "did you mean needles\\[0\\].material.young_modulus"),
                                 ({"young_modulus": [1]}, "young_modulus: scenes have no such field; did you mean"),
                                 ({"needles[2].length": [1]}, "needles\\[2\\]: the scene has no such entry"),
                                 ({"motion.dept": [1]}, "motion.dept: the motion has no such parameter; it has depth, speed"),
                                 ({"motion.entry[0].x": [1]}, "no such parameter"), ({"seed": [1]}, "'seed' is the name of a column"), ({5: [1]}, "expected the name of a field"),
                                 ({STIFFNESS: []}, "at least one value"), ({}, "at least one parameter"),
                                 ({STIFFNESS: range(4000), PUNCTURE: range(4000)}, "grid of more"), ([{"a": 1}, {"b": 1}], "other names")):
            with self.subTest(parameters=str(parameters)[:60]):
                with self.assertRaisesRegex(acus.AcusError, what):
                    acus.Study(self.scene, PUSH, parameters, folder=self.path("none"))
        self.assertFalse(os.path.exists(self.path("none")))

    def test_what_another_case_has_left_is_not_taken_for_it(self):
        first = self.run_study({"motion.tilt": [0.0, 0.1, 0.2]}, run={"recordings": True})
        other = self.run_study({"motion.tilt": [0.2, 0.3, 0.0]}, run={"recordings": True})
        self.assertEqual([other.recording(0), other.recording(2)], [first.recording(2), first.recording(0)])
        for case in range(3):
            with acus.Run(other.recording(case)) as run:
                self.assertAlmostEqual(run["left"].axial_resistance.max(), other.rows[case]["peak_force"], 9)

    def test_classes_count_with_what_they_have_and_inherit(self):
        def made(extra, base=acus.Insertion):
            class Rest(base):
                ticks = extra

                @property
                def more(self):
                    return self.ticks

                @staticmethod
                def twice(number):
                    return 2 * number

                def __call__(self, world):
                    super().__call__(world)
                    world.step(self.more)
            return Rest

        class Base(acus.Insertion):
            offset = 1

        class OtherBase(acus.Insertion):
            offset = 2

        OtherBase.__qualname__, keys = Base.__qualname__, set()
        for kind in (made(5), made(6), made(5, Base), made(5, OtherBase), made(5)):
            keys.add(self.study({"motion.tilt": [0.0]}, motion=kind(0.01, 0.2)).keys[0])
        self.assertEqual(len(keys), 4)

    def test_objects_count_by_what_they_hold(self):
        class Plain:
            def __call__(self, result):
                return 1.0

        class Slotted:
            __slots__ = ("value",)

            def __init__(self, value):
                self.value = value

            def __call__(self, result):
                return self.value

        def key(output):
            return self.study({STIFFNESS: [5e3]}, outputs={"x": output}).keys[0]

        self.assertEqual(key(Plain()), key(Plain()))
        self.assertEqual(key(Slotted(1.0)), key(Slotted(1.0)))
        self.assertNotEqual(key(Slotted(1.0)), key(Slotted(2.0)))
        arrays = [np.array([1, "a"], dtype=object), np.array([1, "b"], dtype=object)]
        self.assertEqual(len({key(lambda result, array=array: len(array)) for array in arrays}), 2)
        self.assertRaisesRegex(acus.StudyError, "nothing says whether it has changed", lambda: key(lambda r, lock=threading.Lock(): 1))

    def test_a_mesh_file_counts_by_its_content(self):
        scene = acus.Scene.read(acus.find_scene("brachytherapy"))
        mesh = self.path("own.msh")
        shutil.copy(os.path.join(scene.folder, scene["tissue.mesh.gmsh.file"]), mesh)
        scene["tissue.mesh.gmsh.file"] = mesh

        def key():
            return acus.Study(scene, PUSH, {"needles[0].length": [0.2]}, folder=self.path("mesh")).keys[0]

        before = key()
        self.assertEqual(key(), before)
        with open(mesh, "ab") as file:
            file.write(b"\n")
        self.assertNotEqual(key(), before)

    def test_columns_have_one_meaning(self):
        for settings, what in (({"outputs": {STIFFNESS: "peak_force"}}, "name of another column"), ({"outputs": {"hash": "tip"}}, "'hash' is the name"),
                               ({"parameters": {STIFFNESS: [1e4], "tissue.regions[gel].material.young_modulus": [2e4]}}, "are the same field")):
            self.assertRaisesRegex(acus.StudyError, what, self.study, **settings)
        made = self.run_study({STIFFNESS: [5e3]}, outputs={"o": lambda r: {"x": 1}, "o.x": lambda r: 5})
        self.assertIn("there is a column 'o.x' already", made.rows[0]["error"])

    def test_a_base_that_would_go_into_the_tissue_is_refused(self):
        made = self.run_study({"motion.depth": [0.05, 0.15, 0.3]})
        self.assertEqual([bool(row["error"]) for row in made.rows], [False, True, True])
        self.assertIn("the base of 'left' would go into the tissue", made.rows[1]["error"])

    def test_a_motion_ends_when_the_base_has_arrived(self):
        self.scene["needles[0].smoothing"] = 0.02
        made = self.run_study({"motion.speed": [0.02, 0.1, 0.5], "motion.pull_back": [False, True]}, motion=acus.Insertion(5e-3))
        tips = {(row["motion.speed"], row["motion.pull_back"]): row["tip.z"] for row in made.rows}
        for speed in (0.02, 0.1, 0.5):  # in air
            self.assertAlmostEqual(tips[speed, False], 0.055, 5)
            self.assertAlmostEqual(tips[speed, True], 0.06, 5)

    def test_files_of_others_are_left_alone(self):
        for name in ("table.csv", "scene.yaml", "study.json", "rows.jsonl"):
            folder = f"study {name}"
            mine = self.write(f"{folder}/{name}", '{"rows": 5}\n')
            self.assertRaisesRegex(acus.StudyError, f"{name}: something else stands there, .*; give the study another folder",
                                   self.study(folder=folder).run, progress=False)
            self.assertEqual(os.listdir(self.path(folder)), [name])
            with open(mine, encoding="utf-8") as file:
                self.assertEqual(file.read(), '{"rows": 5}\n')
        made = self.run_study({STIFFNESS: [5e3]})
        self.run_study({STIFFNESS: [5e3]})
        mine = self.write("mine.csv", "case,a\n1,2\n")
        self.assertRaisesRegex(acus.StudyError, "mine.csv: something else stands there", made.write, mine)
        for _ in range(2):
            made.write(self.path("table.csv"))
        with open(self.path("study", "scene.yaml"), "a", encoding="utf-8") as file:
            file.write("# my notes\n")
        self.assertRaisesRegex(acus.StudyError, "scene.yaml: .* edited, and would be lost", self.study({STIFFNESS: [5e3]}).run, progress=False)

    def test_motions_outputs_and_settings_that_are_none(self):
        for settings, what in (({"outputs": "peak"}, "no output 'peak'; there are peak_force"), ({"outputs": [5]}, "no output '5'"),
                               ({"outputs": ["tip", "tip"]}, "'tip' is there twice"), ({"motion": 5}, "expected an Insertion"),
                               ({"motion": acus.Insertion}, "expected an Insertion"), ({"motion": "nowhere.csv"}, "nowhere.csv: No such")):
            with self.subTest(what=what):
                self.assertRaisesRegex(acus.StudyError, what, self.study, **settings)
        for name, value in (("depth", math.nan), ("speed", 0), ("entry", (0, 1)), ("direction", (0, 0, 0)), ("depth", -1), ("depth", 11),
                            ("hold", "long"), ("pull_back", "False")):
            with self.subTest(name=name):
                self.assertRaisesRegex(acus.StudyError, f"motion.{name}: expected", acus.Insertion, **{"depth": 0.01, name: value})
        self.assertRaisesRegex(acus.StudyError, "workers", self.study().run, workers=-1)
        self.assertRaisesRegex(acus.StudyError, "timeout", self.study().run, timeout=-1)
        for case in (4, -1, "x", None):
            self.assertRaisesRegex(acus.StudyError, "case: expected 0 to 3", self.study().case, case)
        self.assertRaisesRegex(acus.StudyError, "seed", self.study, seed=1.5)
        self.assertRaisesRegex(acus.StudyError, "expected names and functions", self.study, outputs=None)
        self.assertRaisesRegex(acus.StudyError, "ends with .csv or .parquet", self.study().write, self.path("x.xlsx"))
        refused = []

        def in_a_thread():
            try:
                self.study().run(workers=0, timeout=5, progress=False)
            except acus.StudyError as error:
                refused.append(str(error))

        thread = threading.Thread(target=in_a_thread)
        thread.start()
        thread.join()
        self.assertIn("workers=1 or more", refused[0])
        self.assertRaises(acus.ProgramNotFound, acus.Study, "no_such_scene", PUSH, {STIFFNESS: [1]})

    def test_an_output_may_be_text_vector_or_map_and_nothing_else(self):
        made = self.run_study({STIFFNESS: [5e3]}, outputs={"text": lambda r: "a", "two": lambda r: np.arange(2), "map": lambda r: {
            "in": [1, 2, 3], "none": None}, "flag": lambda r: np.bool_(True), "nan": lambda r: math.nan})
        row = made.rows[0]
        self.assertEqual((row["text"], row["two[1]"], row["map.in.z"], row["map.none"], row["flag"]), ("a", 1, 3, None, True))
        self.assertTrue(math.isnan(row["nan"]))
        made = self.run_study({STIFFNESS: [5e3]}, outputs={"strange": lambda r: r})
        self.assertIn("'strange': expected numbers", made.rows[0]["error"])

    def test_prepare_has_parameters_of_its_own(self):
        def prepare(scene, values):
            for needle in scene["needles"]:
                needle["length"] *= values["scale"]

        made = self.run_study({"scale": [1.0, 0.9], STIFFNESS: [5e3]}, prepare=prepare)
        self.assertEqual([row["error"] for row in made.rows], ["", ""])
        self.assertEqual([made.scene(case)["needles[1].length"] for case in (0, 1)], [0.1, 0.9 * 0.1])
        self.assertEqual(self.scene["needles[1].length"], 0.1)
        self.assertNotEqual(made.rows[0]["hash"], made.rows[1]["hash"])

    def test_policies_draw_with_the_seed_of_the_case(self):
        def jitter(world):
            needle = world.needle("right")
            for tick in range(10):
                world.drive(needle, 1e-3 * tick + world.random.normal(0, 1e-4))
                world.step()

        outputs = {"x": lambda result: result.of("right").track.base_position[-1]}
        cases = [{"repeat": 0}, {"repeat": 0}, {"repeat": 1}]
        first, second = (self.run_study(cases, motion=jitter, outputs=outputs, folder=name) for name in "ab")
        self.assertEqual(first.digest, second.digest)
        self.assertEqual(len({row["hash"] for row in first.rows}), 3)
        other = self.run_study(cases, motion=jitter, outputs=outputs, folder="c", seed=1)
        self.assertFalse({row["hash"] for row in other.rows} & {row["hash"] for row in first.rows})

    def test_the_progress_says_how_far_it_is(self):
        class Terminal(io.StringIO):
            def isatty(self):
                return True

        screen, log = Terminal(), io.StringIO()
        for stream in (screen, log):
            shown = Progress(4, 1, stream=stream)
            for failed in (False, True, False):
                shown.add(failed)
            shown.end()
            self.assertIn("1 of 4 cases are there already", stream.getvalue())
            self.assertRegex(stream.getvalue(), r"4/4 done, 1 failed, .* cases/s, took 0 s")
        self.assertTrue(screen.getvalue().endswith("\n") and "\r" in screen.getvalue())
        self.assertNotIn("\r", log.getvalue())


if __name__ == "__main__":
    unittest.main()
