# SPDX-License-Identifier: MIT
"""Places of the tissue that move with it."""

import numpy as np

OUTSIDE = 1e-9  # of a weight below 0


class TissuePoints:
    """Each is held by the tetrahedron that contained it at rest, or came nearest to that: by its shares of the four corners.
    `outside`: whether none contained it, of each."""

    def __init__(self, of, places):
        """`of`: a Model of acus.engine, or a DescribeReply. `places`: m, world, at rest, points x 3."""
        nodes = np.asarray(of.rest_positions if hasattr(of, "rest_positions") else of.positions, dtype=float)
        corners = nodes[of.tetrahedra]  # tetrahedra x 4 x 3
        a, b, c = np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 0)
        # Rows of the inverse of (a b c), in closed form: worlds are threads, and not every LAPACK may be called by several.
        inverse = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
        inverse /= np.sum(a * inverse[:, 0], axis=1)[:, None, None]
        held, shares = [], []
        for place in np.asarray(places, dtype=float):
            three = np.einsum("tij,tj->ti", inverse, place - corners[:, 0])
            four = np.column_stack([1 - three.sum(axis=1), three])
            best = int(np.argmax(four.min(axis=1)))
            held.append(of.tetrahedra[best])
            shares.append(four[best])
        self._nodes, self._shares = np.array(held), np.array(shares)
        self.outside = self._shares.min(axis=1) < -OUTSIDE

    def at(self, positions):
        """Where they are when the nodes are there (m, nodes x 3): m, points x 3."""
        return np.einsum("pc,pcx->px", self._shares, np.asarray(positions, dtype=float)[self._nodes])
