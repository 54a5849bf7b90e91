# SPDX-License-Identifier: MIT
"""Shapes as acus-replay --shapes records them, and cuts through them.

The file is msgpack messages one after the other: see "Recorded shapes" in protocol/README.md. Only the shapes that are
asked for are kept in memory. SI units, world frame.
"""

import msgpack
import numpy as np

from .drawn import Dents
from .errors import RunError

LARGEST_MESSAGE = 2**30  # bytes


class Shapes:
    """What was simulated, and where in the file its shapes are: of an epoch of the run, the last unless told. The file
    stays open: use it in a with statement. Raises RunError. `hello` and `describe` are the server's answers, as maps."""

    def __init__(self, path, epoch=None):
        self.path = path
        self.epoch = epoch
        self.hello = self.describe = None
        self.tissue = []  # (time, place in the file) of each state
        self.needles = {}  # the same, per needle
        self.guides = {}  # (place in the file of the next tissue state, pose), per guide that moves
        try:
            self._file = open(path, "rb")  # pylint: disable=consider-using-with
        except OSError as error:
            raise RunError(f"{path}: {error.strerror}; acus-replay --shapes {path} writes it") from None
        try:
            self._index()
        except (ValueError, KeyError, TypeError, AttributeError, msgpack.UnpackException):
            self.hello = None
        problem = self._problem()
        if problem:
            self.close()
            raise RunError(f"{path}: {problem}")
        self._read_mesh()

    def _problem(self):
        if not self.hello or not self.describe:
            return "expected shapes written by acus-replay --shapes, found something else"
        if not self.tissue or not all(self.needles.values()):
            return "holds no shapes; the run was too short to have any"
        return None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._file.close()

    @property
    def times(self):
        """s, simulation time of each tissue state."""
        return np.array([time for time, _ in self.tissue])

    def _index(self):
        wanted, begin = self.epoch, 0
        unpacker = msgpack.Unpacker(self._file, max_buffer_size=LARGEST_MESSAGE)
        for message in unpacker:
            kind = message["type"]
            if kind in ("tissue", "needle") and not self._is_of(message.get("epoch", 0), wanted):
                pass
            elif kind == "tissue":
                self.tissue.append((message["time"], begin))
            elif kind == "needle":
                self.needles[message["needle"]].append((message["time"], begin))
            elif kind == "pose":
                self.guides.setdefault(message["needle"], []).append((unpacker.tell(), message))
            elif kind == "hello_reply":
                self.hello = message
                self.needles = {needle["name"]: [] for needle in message["needles"]}
            elif kind == "describe_reply":
                self.describe = message
            begin = unpacker.tell()

    def _is_of(self, epoch, wanted):
        """Of the epoch that is wanted; without one a new epoch takes the place of the one before."""
        if wanted is None and epoch != self.epoch:
            self.epoch = epoch
            self.tissue = []
            self.needles = {name: [] for name in self.needles}
        return epoch == self.epoch

    def _read_mesh(self):
        self.rest = unpack(self.describe, "positions", "<f4", 3).astype(float)  # m, nodes x 3
        self.tetrahedra = unpack(self.describe, "tetrahedra", "<i4", 4)
        self.region_of = unpack(self.describe, "tetrahedron_regions", "<i4", 1)[:, 0]
        self.regions = self.describe["regions"]

    def message_at(self, place):
        self._file.seek(place)
        return next(msgpack.Unpacker(self._file, max_buffer_size=LARGEST_MESSAGE))

    def frame(self, time):
        """The first tissue state at or after a simulation time, else the last, with the needles at its time."""
        after = int(np.searchsorted([t for t, _ in self.tissue], time))
        return Frame(self, *self.tissue[min(after, len(self.tissue) - 1)])

    def displacements(self):
        """The largest Displacement of each region's centroid over the run.

        A centroid is the mean over the region's tetrahedra, each weighted with its volume at rest.
        """
        shares = node_shares(self.rest, self.tetrahedra, self.region_of, len(self.regions))
        at_rest = shares @ self.rest
        moved = np.zeros((len(self.tissue), len(self.regions)))
        for row, (_, place) in zip(moved, self.tissue):
            nodes = unpack(self.message_at(place), "positions", "<f4", 3)
            row[:] = np.linalg.norm(shares @ nodes - at_rest, axis=1)
        furthest = np.argmax(moved, axis=0)
        return [Displacement(name, moved[state, region], self.tissue[state][0])
                for region, (name, state) in enumerate(zip(self.regions, furthest))]

    def needle_at(self, name, time):
        """Nodes and orientations of a needle, straight between the two states around a time."""
        states = self.needles[name]
        after = int(np.searchsorted([t for t, _ in states], time))
        before, after = (self.message_at(states[min(max(i, 0), len(states) - 1)][1]) for i in (after - 1, after))
        span = after["time"] - before["time"]
        share = min(max((time - before["time"]) / span, 0), 1) if span > 0 else 0
        return [(1 - share) * unpack(before, field, "<f8", size) + share * unpack(after, field, "<f8", size)
                for field, size in (("positions", 3), ("orientations", 4))]

    def guides_at(self, place):
        """{name: (position, orientation)} of the guides when the tissue state at that place in the file came."""
        poses = {guide["name"]: guide for guide in self.hello["guides"]}
        for name, moves in self.guides.items():
            earlier = [pose for where, pose in moves if where <= place]
            if earlier:
                poses[name] = earlier[-1]
        return {name: (np.array(pose["position"]), np.array(pose["orientation"])) for name, pose in poses.items()}


class Frame:
    """All shapes at one time."""

    def __init__(self, shapes, time, place):
        tissue = shapes.message_at(place)
        self.time = time  # s, simulation time
        self.tissue = unpack(tissue, "positions", "<f4", 3).astype(float)  # m, nodes x 3
        points = unpack(tissue, "path_points", "<f4", 3).astype(float)
        sizes = unpack(tissue, "path_sizes", "<i4", 1)[:, 0]
        self.paths = np.split(points, np.cumsum(sizes)[:-1]) if sizes.size else []  # m, points x 3 each
        self.dents = Dents(*(unpack(tissue, f"dent_{field}", "<f4", size) if f"dent_{field}" in tissue else ()
                             for field, size in (("centres", 3), ("moves", 3), ("radii", 2))))
        self.needles = {name: shapes.needle_at(name, time) for name in shapes.needles}
        self.guides = shapes.guides_at(place)


class Displacement:
    """How far a region was from its place at rest, and when."""

    def __init__(self, region, distance, time):
        self.region = region
        self.distance = distance  # m
        self.time = time  # s, simulation time


def node_shares(nodes, tetrahedra, region_of, regions):
    """How much each node counts in the centroid of each region: regions x nodes, each row adds up to 1."""
    edges = nodes[tetrahedra[:, 1:]] - nodes[tetrahedra[:, :1]]
    volumes = np.abs(np.linalg.det(edges)) / 6
    shares = np.zeros((regions, len(nodes)))
    for corners in tetrahedra.T:
        np.add.at(shares, (region_of, corners), volumes)
    return shares / shares.sum(axis=1, keepdims=True)


def unpack(message, field, kind, columns):
    return np.frombuffer(message[field], kind).reshape(-1, columns)


def cut(nodes, tetrahedra, point, normal):
    """The polygons (3 or 4 corners x 3, m) in which a plane cuts tetrahedra, and which tetrahedron each belongs to.

    A node on the plane counts as above it, so a face that lies in the plane is cut once, from below.
    """
    if not tetrahedra.size:
        return [], np.zeros(0, dtype=int)
    heights = (nodes - point) @ normal
    above = heights[tetrahedra] >= 0
    counts = above.sum(axis=1)
    polygons, owners = [], []
    for count in (1, 2, 3):
        chosen = np.flatnonzero(counts == count)
        order = np.argsort(~above[chosen], axis=1, kind="stable")  # the corners above first
        corners = np.take_along_axis(tetrahedra[chosen], order, axis=1)
        ends = {1: [(0, 1), (0, 2), (0, 3)], 2: [(0, 2), (0, 3), (1, 3), (1, 2)], 3: [(0, 3), (1, 3), (2, 3)]}[count]
        crossings = np.stack([crossing(nodes, heights, corners[:, a], corners[:, b]) for a, b in ends], axis=1)
        solid = area(crossings) > 1e-9 * span_of(nodes) ** 2
        polygons.extend(crossings[solid])
        owners.extend(chosen[solid])
    return polygons, np.array(owners, dtype=int)


def crossing(nodes, heights, upper, lower):
    """Where the edges from a node above to one below meet the plane."""
    share = heights[upper] / (heights[upper] - heights[lower])
    return nodes[upper] + share[:, None] * (nodes[lower] - nodes[upper])


def area(polygons):
    """Of flat polygons with 3 or 4 corners, in order."""
    return 0.5 * np.linalg.norm(np.cross(polygons[:, 2] - polygons[:, 0], polygons[:, -1] - polygons[:, 1]), axis=1)


def span_of(points):
    return float(np.max(np.ptp(points, axis=0)))
