# SPDX-License-Identifier: MIT
"""The tissue of a model: its surface, its regions, and where its points lie at rest."""

import numpy as np

FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])  # of a tetrahedron, seen from outside
ALIKE = 1e-9


def tetrahedra_of(model, region):
    """Those of a region, by its name: n x 4."""
    return model.tetrahedra[model.tetrahedron_regions == list(model.regions).index(region)]


def boundary_of(tetrahedra):
    """Triangles that belong to one tetrahedron alone, seen from outside: n x 3."""
    triangles = tetrahedra[:, FACES].reshape(-1, 3)
    _, first, count = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True, return_counts=True)
    return triangles[np.sort(first[count == 1])]


def centroid_of(model, region):
    """m, of the volume of a region at rest."""
    corners = model.rest_positions[tetrahedra_of(model, region)]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    return volumes @ corners.mean(axis=1) / volumes.sum()


def extent_of(model):
    """In words: where the tissue lies at rest."""
    low, high = model.rest_positions.min(axis=0), model.rest_positions.max(axis=0)
    corners = [", ".join(f"{each:.4g}" for each in corner) for corner in (low, high)]
    return f"the tissue lies between ({corners[0]}) and ({corners[1]}) m in the world"


def distances_to_triangles(points, triangles):
    """Of points (n, 3) to the nearest of triangles (t, 3, 3)."""
    return np.array([distance_to_triangles(point, triangles) for point in points])


def distance_to_triangles(point, triangles):
    a, b, c = np.moveaxis(triangles, 1, 0)
    normals = np.cross(b - a, c - a)
    areas = np.sum(normals * normals, axis=1)
    beside = np.minimum.reduce([np.sum(np.cross(q - p, point - p) * normals, axis=1) for p, q in ((a, b), (b, c), (c, a))])
    over = (beside >= 0) & (areas > 0)
    nearest = [distance_to_segments(point, p, q) for p, q in ((a, b), (b, c), (c, a))]
    if np.any(over):
        nearest.append(np.abs(np.sum((point - a[over]) * normals[over], axis=1)) / np.sqrt(areas[over]))
    return min(float(each.min()) for each in nearest)


def distance_to_segments(point, begin, end):
    way = end - begin
    share = np.clip(np.sum((point - begin) * way, axis=1) / np.maximum(np.sum(way * way, axis=1), 1e-30), 0, 1)
    return np.linalg.norm(begin + share[:, None] * way - point, axis=1)


class Tetrahedra:
    """Of their corners (n, 4, 3): finds in which a point is."""

    def __init__(self, corners):
        self._corners, self._low, self._high = corners, corners.min(axis=1) - ALIKE, corners.max(axis=1) + ALIKE

    def find(self, point):
        """(number, weights of its corners), or None outside."""
        best = None
        for each in np.flatnonzero(np.all((point >= self._low) & (point <= self._high), axis=1)):
            corners = self._corners[each]
            shares = np.linalg.solve((corners[1:] - corners[0]).T, point - corners[0])
            weights = np.array([1 - shares.sum(), *shares])
            if weights.min() > (-1e-6 if best is None else best[1].min()):
                best = each, weights
        return best


class Deformed:
    """The tissue as it lies in a state: finds where its points are at rest."""

    def __init__(self, model, positions):
        self._rest = model.rest_positions[model.tetrahedra]
        self._now = Tetrahedra(np.asarray(positions)[model.tetrahedra])

    def at_rest(self, points):
        """(n, 3) to (n, 3) m; NaN outside the tissue."""
        return np.array([self._at_rest(point) for point in points]).reshape(-1, 3)

    def _at_rest(self, point):
        found = self._now.find(point)
        return np.full(3, np.nan) if found is None else found[1] @ self._rest[found[0]]


class Surface:
    """Of the whole tissue at rest: triangles (n, 3, 3), outer normals (n, 3)."""

    def __init__(self, model):
        faces = boundary_of(model.tetrahedra)
        self.triangles = model.rest_positions[faces]
        a, b, c = np.moveaxis(self.triangles, 1, 0)
        normals = np.cross(b - a, c - a)
        self.areas = np.linalg.norm(normals, axis=1) / 2
        self.normals = normals / np.maximum(2 * self.areas, 1e-30)[:, None]

    def points(self, count, seed=0):
        """Spread evenly over the surface by chance: points (count, 3), the number of the triangle of each."""
        random = np.random.default_rng(seed)
        places = random.choice(len(self.areas), count, p=self.areas / self.areas.sum())
        u, v = np.sort(random.uniform(size=(2, count)), axis=0)
        weights = np.stack([u, v - u, 1 - v], axis=1)
        return np.einsum("nc,ncx->nx", weights, self.triangles[places]), places

    def hit(self, origin, direction):
        """Where a line (both ways) through a point meets the surface from outside, nearest to the point: (point, triangle
        number), or None."""
        a, b, c = np.moveaxis(self.triangles, 1, 0)
        normals = np.cross(b - a, c - a)
        slope = normals @ direction
        facing = slope < -1e-12 * np.linalg.norm(normals, axis=1)
        ways = np.where(facing, np.sum((a - origin) * normals, axis=1) / np.where(facing, slope, 1), np.nan)
        points = origin + ways[:, None] * direction
        inside = np.minimum.reduce([np.sum(np.cross(q - p, points - p) * normals, axis=1) for p, q in ((a, b), (b, c), (c, a))])
        meets = np.flatnonzero(facing & (inside >= -1e-9 * np.sum(normals * normals, axis=1)))
        if not meets.size:
            return None
        nearest = meets[np.argmin(np.abs(ways[meets]))]
        return points[nearest], int(nearest)
