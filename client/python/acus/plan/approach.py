# SPDX-License-Identifier: MIT
"""How planned insertions are tried and judged."""

import dataclasses
import json

import numpy as np

from ..errors import PlanError
from ..study.motions import Insertion
from ..tissue_points import TissuePoints
from .tissue import Deformed, extent_of

DENSE = 1e-3  # m, between points of a line
DIGITS = 5  # of m, of paths in tables


class TissuePoint:
    """A point of the tissue (m, world, at rest), which moves with it."""

    def __init__(self, model, point, field):
        """`field` names it in errors."""
        self._points = TissuePoints(model, [point])
        if self._points.outside[0]:
            raise PlanError(f"{field}: {np.asarray(point).tolist()} is not inside the tissue; {extent_of(model)}")

    def at(self, state):
        return self._points.at(state.tissue_positions)[0]


@dataclasses.dataclass(frozen=True)
class Approach(Insertion):
    """Goes in until the tip passes the target, which moves with the tissue, at most to `depth`. Each depth of `tries` makes a
    branch of it, which flips there; `world.notes["ends"]` has the End of each, that without a try first."""

    target: tuple = None  # m, world, at rest
    stop: float = 0.0  # m before the tip passes the target
    tries: tuple = ()  # m behind the entry

    def __call__(self, world):
        needle, target = world.needle(self.needle), TissuePoint(world.model, self.target, "target")
        self.check_base(world, needle, self.way)
        places = self.places(world)
        branches = [Branch(flip, places, dataclasses.replace(self, flips=(*self.flips, flip)).places(world)) for flip in self.tries]
        ends = []
        for tick, place in enumerate(places):
            for branch in branches:
                if branch.begin == tick:
                    ends.append(self._end(world.branch(), needle, target, branch.places[tick:], branch.flip))
            if self._step(world, needle, target, place):
                break
        world.settle(needle)
        world.notes["ends"] = [End(world, place[0] - (self.way - self.depth), None), *ends]

    def _end(self, world, needle, target, places, flip):
        for place in places:
            if self._step(world, needle, target, place):
                break
        world.settle(needle)
        return End(world, place[0] - (self.way - self.depth), flip)

    def _step(self, world, needle, target, place):
        """Whether the tip has passed the target."""
        world.drive(needle, *place)
        world.step()
        before, tip = world.state.needle_positions(needle.name)[-2:]
        heading = (tip - before) / np.linalg.norm(tip - before)
        return (target.at(world.state) - tip) @ heading <= self.stop


@dataclasses.dataclass
class End:
    """Of an approach: its World, how deep it was commanded (m), and the try that it is of, or None."""

    world: object
    depth: float
    flip: float


class Branch:
    """`begin`: the first tick that differs from the way without the flip."""

    def __init__(self, flip, trunk, places):
        self.flip, self.places = flip, places
        alike = [(a, a_spin or 0.0) == (b, b_spin or 0.0) for (a, a_spin), (b, b_spin) in zip(trunk, places)]
        self.begin = alike.index(False) if False in alike else len(trunk)


@dataclasses.dataclass(frozen=True)
class Judged:
    """What counts of an end: `miss`, from the tip to the target, m, world; `force`, the largest axial resistance, N; `shaft`,
    the needle in the tissue, and `cut`, what its tip has cut, as points of the tissue at rest, JSON; `clearance` to each place
    to avoid, m, of the needle's surface, by both."""

    target: tuple
    avoid: tuple = ()  # of (name, Place)

    def __call__(self, result):
        return self.of(result.world, result.needle)

    def of(self, world, needle):
        model, state = world.model, world.state
        nodes, tissue = state.needle_positions(needle.name), Deformed(model, state.tissue_positions)
        shaft = inside(tissue, nodes)
        cut = np.concatenate([np.zeros((0, 3)), *(inside(tissue, path) for path in state.paths[world.old_paths:] if len(path))])
        return {"miss": TissuePoint(model, self.target, "target").at(state) - nodes[-1],
                "force": float(max(-report[needle.name].base_force_in_base[0] for report in world.reports)),
                "shaft": rounded(shaft), "cut": rounded(cut),
                "clearance": clearances(model, self.avoid, np.concatenate([shaft, cut]), needle.diameter / 2)}


@dataclasses.dataclass(frozen=True)
class JudgedEnds:
    """Likewise of all ends of an Approach, with their depths: {"0": ..., "1": ...}."""

    judged: Judged

    def __call__(self, result):
        return {str(i): {"flip": end.flip, "depth": end.depth, **self.judged.of(end.world, result.needle)}
                for i, end in enumerate(result.world.notes["ends"])}


def clearances(model, avoid, points, radius):
    """{name: m} of a needle of that radius along points at rest (n, 3)."""
    return {name: float(place.distances(model, points).min()) - radius if len(points) else np.inf for name, place in avoid}


def inside(tissue, line):
    """Points of a line that lie in the tissue, at rest (n, 3)."""
    points = tissue.at_rest(dense(line))
    return points[np.all(np.isfinite(points), axis=1)]


def rounded(points):
    return json.dumps(np.round(points, DIGITS).tolist())


def dense(points):
    """With more between those that are farther apart than DENSE."""
    points = np.asarray(points, dtype=float)
    parts = [points[:1]]
    for a, b in zip(points, points[1:]):
        count = max(1, int(np.ceil(np.linalg.norm(b - a) / DENSE)))
        parts.append(a + np.arange(1, count + 1)[:, None] / count * (b - a))
    return np.concatenate(parts)
