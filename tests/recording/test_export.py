#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what acus-export --vtk wrote of a recorded run with VTK's own readers, as ParaView does, and compares it with the
forces of the same run.

Usage: test_export.py BINARIES SCENES. Exit status 77: python3-vtk9 is not there."""

import csv
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest

try:
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader
except ImportError:
    print("python3-vtk9 is not there")
    sys.exit(77)

SCENES, BINARIES = sys.argv.pop(), sys.argv.pop()


def record(folder, scene, trajectory):
    """A recording of a run in lockstep."""
    ends = [f"--{name}=ipc://{folder}/{name}" for name in ("commands", "states")]
    recording = os.path.join(folder, "run.acus")
    with subprocess.Popen([f"{BINARIES}/acus-server", f"{SCENES}/{scene}.yaml", *ends, "--lockstep",
                           f"--record={recording}"], stderr=subprocess.DEVNULL) as server:
        subprocess.run([f"{BINARIES}/acus-replay", f"{SCENES}/trajectories/{trajectory}.csv", *ends, "--lockstep",
                        "--shutdown"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=300)
        server.wait(60)
    return recording


def export(*arguments):
    return subprocess.run([f"{BINARIES}/acus-export", *arguments], capture_output=True, text=True, timeout=300,
                          check=False)


def frames(folder, collection):
    """(time, file) of each frame."""
    with open(os.path.join(folder, collection + ".pvd"), encoding="utf-8") as file:
        found = re.findall(r'timestep="([^"]*)" part="0" file="([^"]*)"', file.read())
    return [(float(time), os.path.join(folder, name)) for time, name in found]


def read(path):
    reader = vtkXMLUnstructuredGridReader() if path.endswith(".vtu") else vtkXMLPolyDataReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


class Export(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.recording = record(cls.folder.name, "inclusion_soft_needle", "inclusion_soft_needle")
        cls.vtk = os.path.join(cls.folder.name, "frames")
        cls.csv = os.path.join(cls.folder.name, "run.csv")
        cls.result = export(cls.recording, "--vtk", cls.vtk, "--csv", cls.csv, "--rate", "5")
        with open(cls.csv, encoding="utf-8") as file:
            cls.rows = list(csv.DictReader(file))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def row_at(self, time):
        return min(self.rows, key=lambda row: abs(float(row["time_s"]) - time))

    def test_the_run_is_the_same(self):
        self.assertEqual(self.result.returncode, 0, self.result.stderr)
        self.assertIn("the same to the last bit", self.result.stdout)

    def test_frames_come_at_their_rate(self):
        times = [time for time, _ in frames(self.vtk, "needles")]
        self.assertGreater(len(times), 5)
        for before, after in zip(times, times[1:]):
            self.assertAlmostEqual(after - before, 0.2, delta=0.011)
        for name in ("tissue", "paths", "forces"):
            self.assertEqual([time for time, _ in frames(self.vtk, name)], times)

    def test_tissue_has_its_tetrahedra_regions_and_displacements(self):
        first, last = (read(frames(self.vtk, "tissue")[i][1]) for i in (0, -1))
        self.assertEqual(first.GetNumberOfCells(), last.GetNumberOfCells())
        self.assertGreater(first.GetNumberOfCells(), 100)
        self.assertEqual(first.GetCellType(0), 10)
        self.assertEqual(first.GetCellData().GetArray("region").GetRange(), (0, 1))
        moved = [read(file).GetPointData().GetArray("displacement").GetRange(-1)[1]
                 for _, file in frames(self.vtk, "tissue")]
        self.assertLess(moved[0], 1e-4)
        self.assertGreater(max(moved), 1e-3)
        rest = [math.dist(last.GetPoint(i), last.GetPointData().GetArray("displacement").GetTuple(i))
                for i in range(3)]
        self.assertTrue(all(math.isfinite(x) for x in rest))

    def test_needles_end_at_their_tips(self):
        for time, file in frames(self.vtk, "needles"):
            needles, row = read(file), self.row_at(time)
            self.assertEqual(needles.GetNumberOfLines(), 1)
            tip = needles.GetPoint(needles.GetNumberOfPoints() - 1)
            for axis, value in zip("xyz", tip):
                self.assertAlmostEqual(value, float(row[f"tip_position_{axis}_m"]), places=12)
            self.assertAlmostEqual(needles.GetCellData().GetArray("depth").GetValue(0), float(row["depth_m"]), places=12)

    def test_forces_are_those_of_the_run(self):
        for time, file in frames(self.vtk, "forces"):
            forces, row = read(file).GetPointData().GetArray("force"), self.row_at(time)
            for point, name in enumerate(("tip_force", "base_force")):
                for axis, value in zip("xyz", forces.GetTuple(point)):
                    self.assertAlmostEqual(value, float(row[f"{name}_{axis}_N"]), places=12)

    def test_paths_grow_with_the_needle(self):
        sizes = [read(file).GetNumberOfPoints() for _, file in frames(self.vtk, "paths")]
        self.assertEqual(sizes[0], 0)
        self.assertGreater(max(sizes), 3)

    def test_a_folder_that_is_not_empty_and_a_file_that_is_none_are_refused(self):
        again = export(self.recording, "--vtk", self.vtk)
        self.assertEqual(again.returncode, 3)
        self.assertIn("is not empty", again.stderr)
        self.assertEqual(export(self.csv).returncode, 2)
        self.assertEqual(export(os.path.join(self.folder.name, "none")).returncode, 1)


if __name__ == "__main__":
    unittest.main()
