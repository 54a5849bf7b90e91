# SPDX-License-Identifier: MIT
"""The tissue as it is to be drawn: a mesh is too coarse to show the dimple under a tip, or the skin that a shaft drags
along; the dents of a state have it. SI units, world frame.

    dents = acus.Dents.of(states.tissue)                       # of a `tissue` state, or acus.Dents(*state.dents)
    points = dents.displaced(states.tissue.positions)          # where the nodes really are
    nodes, triangles = dents.surface(positions, triangles)     # more and smaller triangles where there are dents
"""

import numpy as np

# A piece of a surface around a dent is no longer than this share of its distance from the centre, or of r.
FINEST = 0.5
# Pieces end where a dent displaces less than this (m).
SEEN = 5e-5
MOST_HALVINGS = 12
# A triangle has a dent's centre in it where that lies no further from its plane, and from its corners, than this share of r.
APART = 0.1
# How far a triangle reaches from one of its edges, as a share of that.
BESIDE = 0.3


class Dents:
    """Displacements around places where needles load the tissue: at a point x of the mesh the tissue is displaced by the sum of
    move * s(|x - centre|), s(d) = (1/hypot(d, r) - 1/hypot(d, R)) / (1/r - 1/R), with r, R = radii."""

    def __init__(self, centres=(), moves=(), radii=()):
        self.centres = np.asarray(centres, dtype=float).reshape(-1, 3)  # m
        self.moves = np.asarray(moves, dtype=float).reshape(-1, 3)  # m
        self.radii = np.asarray(radii, dtype=float).reshape(-1, 2)  # m, 0 < r < R
        if not len(self.centres) == len(self.moves) == len(self.radii):
            raise ValueError(f"dents: expected as many centres as moves and radii, found {len(self.centres)}, "
                             f"{len(self.moves)} and {len(self.radii)}")
        shows = self.radii[:, 0] < self.radii[:, 1]
        self.centres, self.moves, self.radii = self.centres[shows], self.moves[shows], self.radii[shows]

    @classmethod
    def of(cls, tissue):
        """Of a TissueShape."""
        return cls(tissue.dent_centres, tissue.dent_moves, tissue.dent_radii)

    def __len__(self):
        return len(self.centres)

    def displacement(self, points):
        """m, of points of the mesh (..., 3)."""
        points = np.asarray(points, dtype=float)
        total = np.zeros_like(points)
        for centre, move, (inner, outer) in zip(self.centres, self.moves, self.radii):
            distance = np.linalg.norm(points - centre, axis=-1)
            total += share_at(distance, inner, outer)[..., None] * move
        return total

    def displaced(self, points):
        return np.asarray(points, dtype=float) + self.displacement(points)

    def surface(self, nodes, triangles):
        """Nodes (n x 3, m) and triangles (m x 3) of a mesh's surface, displaced, with edges halved where dents need it, and nodes at
        their centres: a needle's tip lies on the skin. The first nodes are those given. Edges that triangles share are halved in
        both: there are no gaps."""
        nodes, triangles = self._halved(np.asarray(nodes, dtype=float), np.asarray(triangles))
        for centre, move, (inner, _) in zip(self.centres, self.moves, self.radii):
            if np.linalg.norm(move) > SEEN:
                nodes, triangles = with_centre(nodes, triangles, centre, APART * inner)
        nodes, triangles = self._halved(nodes, triangles)
        return self.displaced(nodes), triangles

    def _halved(self, nodes, triangles):
        for _ in range(MOST_HALVINGS):
            edges = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
            edges = edges[self._too_long(nodes[edges[:, 0]], nodes[edges[:, 1]])]
            if not len(edges):
                break
            middles = dict(zip(map(tuple, edges.tolist()), range(len(nodes), len(nodes) + len(edges))))
            nodes = np.concatenate([nodes, nodes[edges].mean(axis=1)])
            triangles = np.array([piece for triangle in triangles.tolist() for piece in halved(triangle, middles)])
        return nodes, triangles

    def outline(self, polygon):
        """A polygon's corners (n x 3, m), and points of its edges where dents need them, displaced."""
        corners = np.asarray(polygon, dtype=float)
        for _ in range(MOST_HALVINGS if len(self) else 0):
            ends = np.roll(corners, -1, axis=0)
            long = np.flatnonzero(self._too_long(corners, ends))
            if not long.size:
                break
            corners = np.insert(corners, long + 1, (corners[long] + ends[long]) / 2, axis=0)
        return self.displaced(corners)

    def _too_long(self, a, b):
        """Whether the edges from a to b (n x 3 each) are too long to show the dents."""
        length = np.linalg.norm(b - a, axis=1)
        too_long = np.zeros(len(a), dtype=bool)
        for centre, move, (inner, outer) in zip(self.centres, self.moves, self.radii):
            along = np.clip(((centre - a) * (b - a)).sum(axis=1) / np.maximum(length**2, 1e-30), 0, 1)
            nearest = np.linalg.norm(a + along[:, None] * (b - a) - centre, axis=1)
            beside = np.maximum(0, nearest - BESIDE * length)
            seen = share_at(beside, inner, outer) * np.linalg.norm(move) > SEEN
            too_long |= seen & (length > FINEST * np.hypot(nearest, inner))
        return too_long


def share_at(distance, inner, outer):
    """s, of a dent at a distance (m) from its centre."""
    return (1 / np.hypot(distance, inner) - 1 / np.hypot(distance, outer)) / (1 / inner - 1 / outer)


def with_centre(nodes, triangles, centre, apart):
    """With the triangle over which a centre lies (m) divided into three that meet there, unless one of its corners is as near, or it
    is further away than `apart`."""
    a, b, c = (nodes[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    squares = np.maximum((normals**2).sum(axis=1), 1e-60)
    of_b = (np.cross(centre - a, c - a) * normals).sum(axis=1) / squares
    of_c = (np.cross(b - a, centre - a) * normals).sum(axis=1) / squares
    heights = np.abs(((centre - a) * normals).sum(axis=1)) / np.sqrt(squares)
    over = (of_b > 0) & (of_c > 0) & (of_b + of_c < 1) & (heights <= apart)
    if not over.any():
        return nodes, triangles
    t = np.argmin(np.where(over, heights, np.inf))
    place = a[t] + of_b[t] * (b[t] - a[t]) + of_c[t] * (c[t] - a[t])
    first, second, third = corners = triangles[t]
    if np.linalg.norm(nodes[corners] - place, axis=1).min() <= apart:
        return nodes, triangles
    meets = len(nodes)
    three = [[first, second, meets], [second, third, meets], [third, first, meets]]
    return np.concatenate([nodes, [place]]), np.concatenate([np.delete(triangles, t, axis=0), three])


def halved(triangle, middles):
    """The triangles that are left of one whose edges have these middles, {(lower node, higher node): middle}."""
    a, b, c = triangle
    ab, bc, ca = (middles.get((min(p, q), max(p, q))) for p, q in ((a, b), (b, c), (c, a)))
    count = sum(m is not None for m in (ab, bc, ca))
    if count == 0:
        return [triangle]
    if count == 3:
        return [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    # turned so that the first edge is halved, and with two the last is not
    while ab is None or (count == 2 and bc is None):
        a, b, c, ab, bc, ca = b, c, a, bc, ca, ab
    if count == 1:
        return [[a, ab, c], [ab, b, c]]
    return [[ab, b, bc], [a, ab, bc], [a, bc, c]]
