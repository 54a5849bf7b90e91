# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs acus-bench (the only argument) on the scenes of scenes/benchmark that load quickly, and reads what it writes."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

BENCH = sys.argv.pop()
SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scenes")
TRAJECTORY = os.path.join(SCENES, "benchmark", "insertion_60mm.csv")
DISTRIBUTION = {"p50_ms", "p99_ms", "max_ms"}
# kStageNames of server/engine/state/report.h.
STAGES = ["take_commands", "needle_free_motion", "tissue_free_motion", "locate", "build_rows"]
STAGES += ["compute_compliance", "solve_laws", "correct", "transitions", "report"]


def bench(*arguments, **environment):
    return subprocess.run([BENCH, *arguments], capture_output=True, text=True, timeout=300, check=False,
                          env=dict(os.environ, **environment))


def scene(name):
    return os.path.join(SCENES, "benchmark", name + ".yaml")


class Scenes(unittest.TestCase):
    def measured(self, name, nodes):
        done = bench(scene(name), TRAJECTORY, "--ticks", "400", "--json", "-")
        self.assertEqual(done.returncode, 0, done.stderr)
        result = json.loads(done.stdout)
        self.assertEqual((result["nodes"], result["ticks"], result["allocations"]), (nodes, 400, 0))
        self.assertEqual((result["rung"], result["solver"]), ("warped", "direct"))
        self.assertRegex(result["state_hash"], "^[0-9a-f]{16}$")
        self.assertGreater(result["rows"], 0)
        self.assertGreater(result["calibration_ms"], 0)
        self.assertLess(result["residual_max"], 1e-3)
        self.assertLessEqual(result["imbalance_share"], 1)
        self.assertEqual(set(result["ratios"]), {"wall", "processor"})
        self.assertEqual(list(result["stages"]), STAGES)
        for times in [result["tick"], *result["stages"].values()]:
            self.assertEqual(set(times), DISTRIBUTION)
            self.assertTrue(0 <= times["p50_ms"] <= times["p99_ms"] <= times["max_ms"])

    def test_cube_1000(self):
        self.measured("cube_1000", 1000)

    def test_cube_3375(self):
        self.measured("cube_3375", 3375)

    def test_rows_200(self):
        self.measured("rows_200", 1000)


class Program(unittest.TestCase):
    def test_a_limit_decides_over_the_exit_status(self):
        options = [scene("cube_1000"), TRAJECTORY, "--ticks", "20", "--no-calibration", "--quiet"]
        done = bench(*options, "--max-p99-ms", "0")
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertIn("acus-bench: --max-p99-ms 0 was exceeded: ", done.stderr)
        self.assertEqual(bench(*options, "--max-p99-ms", "1e6", "--max-late-per-1000", "1000").returncode, 0)

    def test_rung_and_solver_are_those_asked_for(self):
        options = ["--ticks", "20", "--rung", "exact", "--solver", "gauss_seidel", "--needle", "rigid", "--quiet"]
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "result.json")
            done = bench(scene("cube_1000"), TRAJECTORY, *options, "--json", file)
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
            with open(file, encoding="utf-8") as text:
                result = json.load(text)
        self.assertEqual((result["rung"], result["solver"]), ("exact", "gauss_seidel"))

    def test_no_times_are_told_where_no_tick_counts(self):
        for options in [["--ticks", "5"], ["--ticks", "30", "--min-rows", "10000"], ["--ticks", "30", "--skip", "9"]]:
            with self.subTest(options):
                done = bench(scene("cube_1000"), TRAJECTORY, *options, "--json", "-")
                self.assertEqual(done.returncode, 2)
                self.assertIn("no tick counted", done.stderr)
                result = json.loads(done.stdout)
                self.assertEqual(result["tick"], {"p50_ms": None, "p99_ms": None, "max_ms": None})
                self.assertEqual((result["rows"], result["ticks_counted"]), (None, 0))

    def test_the_table_is_for_eyes(self):
        done = bench(scene("cube_1000"), TRAJECTORY, "--ticks", "50")
        self.assertEqual(done.returncode, 0, done.stderr)
        words = ["tick p50 / calibration", "compliance + solve", "heap allocations in ticks     0", "force of its tick"]
        for line in STAGES + words:
            self.assertIn(line, done.stdout)

    def test_help_teaches_by_examples(self):
        done = bench("--help")
        self.assertEqual(done.returncode, 0)
        self.assertIn("acus-bench scenes/benchmark/cube_1000.yaml", done.stdout)

    def test_kernels_are_chosen_by_name_and_compute_the_same(self):
        options = [scene("cube_1000"), TRAJECTORY, "--ticks", "50", "--no-calibration", "--json", "-"]
        widest = json.loads(bench(*options).stdout)
        narrow = json.loads(bench(*options, ACUS_INSTRUCTION_SET="v3").stdout)
        self.assertEqual(narrow["kernels"], "v3")
        self.assertIn(widest["kernels"], ["v3", "v4"])
        self.assertEqual(widest["state_hash"], narrow["state_hash"])
        done = bench(*options, ACUS_INSTRUCTION_SET="sse2")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"ACUS_INSTRUCTION_SET: expected (v4 or )?v3 here, found 'sse2'")

    def test_a_ratio_that_is_worse_than_before_decides_over_the_exit_status(self):
        options = [scene("cube_1000"), TRAJECTORY, "--ticks", "400", "--json", "-"]
        run = json.loads(bench(*options).stdout)
        head = "date,commit,processor,kernels,scene,tick_p50_to_calibration,tick_p99_to_p50,state_hash,change\n"
        row = f"2026-01-01,abc,{run['processor']},{run['kernels']},cube_1000,%s,%s,0,a change\n"
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "history.csv")
            for text, status, words in [
                (head + row % (1e-3, 1e-3) + row % (1e3, 1e3), 0, "at abc (2026-01-01)"),
                (head + row % (1e-3, 1e3), 5, "tick p50 / calibration"),
                (head + row % (1e3, 1e-3), 5, "tick p99 / p50"),
                (head, 0, "has no measurement of cube_1000 on "),
                ("date\n", 3, file + ": expected a file that begins with the line date,commit"),
                (head + row % ("fast", 1), 3, file + ":2: expected a ratio above zero, found 'fast'"),
                (head + "a,b\n", 3, file + ":2: expected 9 cells, found 2"),
            ]:
                with self.subTest(words):
                    with open(file, "w", encoding="utf-8") as table:
                        table.write(text)
                    done = bench(*options, "--against", file)
                    self.assertEqual(done.returncode, status, done.stderr)
                    self.assertIn(words, done.stderr)

    def test_what_cannot_be_used_is_named(self):
        for arguments, status, words in [
            (["no.yaml", TRAJECTORY], 2, "no.yaml: expected a scene file"),
            ([scene("cube_1000"), "no.csv"], 2, "no.csv"),
            ([os.path.join(SCENES, "deep_brain.yaml"), TRAJECTORY], 2, "the trajectory moves 'needle'"),
            ([scene("cube_1000"), TRAJECTORY, "--core", "1000000"], 3, "--core: processor 1000000"),
            ([scene("cube_1000"), TRAJECTORY, "--rung", "wrapped"], 1, "wrapped"),
            ([scene("cube_1000"), TRAJECTORY, "--skip", "-1"], 1, "--skip"),
            (["no.yaml", TRAJECTORY, "--json", "/no/such/folder/x.json"], 3, "/no/such/folder/x.json: cannot be written"),
        ]:
            with self.subTest(words):
                done = bench(*arguments)
                self.assertEqual(done.returncode, status, done.stderr)
                self.assertIn(words, done.stderr)


if __name__ == "__main__":
    unittest.main()
