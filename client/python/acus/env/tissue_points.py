# SPDX-License-Identifier: MIT
"""Places of the tissue that move with it."""

import numpy as np


class TissuePoints:
    """Each is held by the tetrahedron that contained it at rest (DescribeReply), or came nearest to that: by its shares
    of the four corners."""

    def __init__(self, described, places):
        corners = described.positions.astype(float)[described.tetrahedra]  # tetrahedra x 4 x 3
        a, b, c = np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 0)
        # Rows of the inverse of (a b c), in closed form: worlds are threads, and not every LAPACK may be called by several.
        inverse = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
        inverse /= np.sum(a * inverse[:, 0], axis=1)[:, None, None]
        nodes, shares = [], []
        for place in np.asarray(places, dtype=float):
            three = np.einsum("tij,tj->ti", inverse, place - corners[:, 0])
            four = np.column_stack([1 - three.sum(axis=1), three])
            best = int(np.argmax(four.min(axis=1)))
            nodes.append(described.tetrahedra[best])
            shares.append(four[best])
        self._nodes = np.array(nodes)
        self._shares = np.array(shares)

    def at(self, positions):
        """Where they are when the nodes are there (m, nodes x 3): m, points x 3."""
        return np.einsum("pc,pcx->px", self._shares, np.asarray(positions, dtype=float)[self._nodes])
