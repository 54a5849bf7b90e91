#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""tests/study/random-insertions: what it draws, and what it counts as a step."""

import os
import sys
import unittest

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "client", "python"), os.path.join(ROOT, "tests", "study")]

from acus.plan.tissue import boundary_of  # noqa: E402
from insertions import draw, measure, tell  # noqa: E402


def along_x(values):
    return np.array([[value, 0, 0] for value in values], dtype=float)


class Steps(unittest.TestCase):
    def test_one_tick_that_differs_is_a_jump(self):
        jumps = measure.jumps_of(along_x([0, 0.1, 0.2, 0.3, 1.3, 1.4, 1.5, 1.6]))
        self.assertEqual(int(np.argmax(jumps)), 4)
        self.assertAlmostEqual(jumps[4], 0.9)

    def test_what_rises_faster_or_ends_to_rise_is_none(self):
        for values in ([0, 0.1, 0.3, 0.6, 1.0, 1.5], [0, 0.5, 1, 1, 1, 1], [1, 1, 1, 0.5, 0]):
            self.assertLess(measure.jumps_of(along_x(values)).max(), 0.11)

    def test_an_event_just_before_explains_a_step(self):
        forces = along_x([0.0] * 20 + [1.0] * 20)
        nothing = np.zeros(40)

        def course(*events):
            return measure.Course(forces, nothing, np.zeros(40, dtype=int), list(events), nothing, nothing)
        self.assertEqual([step.tick for step in measure.steps_of(course())], [20])
        self.assertEqual(measure.steps_of(course((18, "puncture", 1.0))), [])
        self.assertEqual(measure.steps_of(course((25, "release", 0.0)))[0].follows, "release")


class Triangles(unittest.TestCase):
    def test_nearest_points_inside_and_on_edges(self):
        a, b, c = (np.array([each]) for each in ([0.0, 0, 0], [1.0, 0, 0], [0.0, 1, 0]))
        for point, nearest in (((0.2, 0.2, 0.5), (0.2, 0.2, 0)), ((2, -1, 0), (1, 0, 0)), ((0.7, 0.7, 0), (0.5, 0.5, 0)), ((-1, 0.5, 1), (0, 0.5, 0))):
            np.testing.assert_allclose(measure.nearest_on_triangles(np.array(point, dtype=float), a, b, c)[0], nearest, atol=1e-12)

    def test_the_surface_of_a_tetrahedron_faces_outwards(self):
        nodes = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
        corners = nodes[boundary_of(np.array([[0, 1, 2, 3]]))]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.assertTrue((((corners.mean(axis=1) - nodes.mean(axis=0)) * normals).sum(axis=1) > 0).all())


class Insertions(unittest.TestCase):
    def test_a_number_is_an_insertion_and_its_figures(self):
        first, again = draw.draw(2), draw.draw(2)
        self.assertEqual(first.scene, again.scene)
        np.testing.assert_array_equal(first.moves, again.moves)
        rows = [measure.figures(insertion, measure.run(insertion)) for insertion in (first, again)]
        self.assertEqual(rows[0], rows[1])
        self.assertTrue(rows[0]["finite"])
        self.assertGreater(rows[0]["largest"], 0)
        self.assertIn("2 insertions", tell.table(rows))
        self.assertTrue(tell.holds(rows))


if __name__ == "__main__":
    unittest.main()
