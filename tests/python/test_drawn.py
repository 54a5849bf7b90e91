# SPDX-License-Identifier: MIT
"""acus.Dents: the shape, and surfaces and outlines drawn with it."""

import os
import sys
import unittest

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "..", "client", "python"))
import acus  # noqa: E402

RADII = (1e-3, 5e-3)


def plate(cells, size=0.05):
    """Nodes and triangles of a square around the origin, at z = 0."""
    line = np.linspace(-size / 2, size / 2, cells + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    nodes = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    number = np.arange(x.size).reshape(cells + 1, cells + 1)
    a, b, c, d = number[:-1, :-1].ravel(), number[1:, :-1].ravel(), number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    return nodes, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


class TestDents(unittest.TestCase):
    def setUp(self):
        self.dents = acus.Dents([[1e-3, 2e-3, 0]], [[0, 0, -3e-3]], [RADII])

    def test_displaces_its_centre_by_its_move_and_far_points_by_nothing(self):
        np.testing.assert_allclose(self.dents.displaced([1e-3, 2e-3, 0]), [1e-3, 2e-3, -3e-3])
        np.testing.assert_allclose(self.dents.displacement(np.full((4, 3), 1.0)), np.zeros((4, 3)), atol=1e-9)

    def test_none_displaces_nothing(self):
        points = np.arange(6.0).reshape(2, 3)
        np.testing.assert_array_equal(acus.Dents().displaced(points), points)
        np.testing.assert_array_equal(acus.Dents().outline(points), points)

    def test_lists_of_different_length_are_refused(self):
        with self.assertRaisesRegex(ValueError, "as many centres as moves and radii, found 1, 0 and 1"):
            acus.Dents([[0, 0, 0]], [], [RADII])

    def test_a_surface_of_large_triangles_shows_the_dent(self):
        nodes, triangles = plate(4)
        drawn, pieces = self.dents.surface(nodes, triangles)
        np.testing.assert_allclose(drawn[: len(nodes)], self.dents.displaced(nodes))
        lowest = drawn[np.argmin(drawn[:, 2])]
        self.assertLess(np.linalg.norm(lowest - [1e-3, 2e-3, -3e-3]), 3e-4)
        # Without gaps: every edge belongs to two triangles, but for the plate's rim; and the area that it covers is its own.
        edges = np.sort(pieces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        places, counts = np.unique(edges, axis=0, return_counts=True)
        on_rim = np.all(np.isclose(np.abs(drawn[places][:, :, :2]).max(axis=2), 0.025), axis=1)
        np.testing.assert_array_equal(counts[~on_rim], 2)
        sides = drawn[pieces[:, 1:], :2] - drawn[pieces[:, :1], :2]
        areas = np.linalg.det(sides) / 2
        self.assertGreater(areas.min(), 0)
        self.assertAlmostEqual(areas.sum(), 0.05**2, places=12)

    def test_a_narrow_dent_within_a_triangle_has_a_node_at_its_centre(self):
        nodes, triangles = plate(2)
        rng = np.random.default_rng(4)
        for x, y in rng.uniform(-0.02, 0.02, (20, 2)):
            dents = acus.Dents([[x, y, 0], [x + 1e-5, y, 0]], [[0, 0, -3e-4], [0, 0, 0]], [(1e-4, 8e-3), RADII])
            drawn, pieces = dents.surface(nodes, triangles)
            lowest = np.linalg.norm(drawn - [x, y, -3e-4], axis=1).min()
            self.assertLess(lowest, 2e-5)
            self.assertLess(len(pieces), 1000)
            sides = drawn[pieces[:, 1:], :2] - drawn[pieces[:, :1], :2]
            self.assertAlmostEqual(np.abs(np.linalg.det(sides)).sum() / 2, 0.05**2, places=12)

    def test_an_outline_follows_the_dent(self):
        square = np.array([[-0.02, 2e-3, -0.02], [0.02, 2e-3, -0.02], [0.02, 2e-3, 0], [-0.02, 2e-3, 0]])
        drawn = self.dents.outline(square)
        self.assertGreater(len(drawn), 12)
        top = drawn[drawn[:, 2] > -4e-3]
        self.assertLess(top[:, 2].min(), -2.7e-3)


if __name__ == "__main__":
    unittest.main()
