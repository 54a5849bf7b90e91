# SPDX-License-Identifier: MIT
"""Insertions that a planner considers, and how one follows from another without simulating it.

A path turns and moves with the needle that cuts it, as in tissue that is alike everywhere. So a tip that missed is corrected
by the direction that takes it to the target, or, where the direction is given, by the entry; what the tissue does else, the
next simulation tells.
"""

import dataclasses
import json
import math

import numpy as np

from ..rotation import conjugate, multiply, rotate, rotation_about, shortest_rotation, unit
from .approach import clearances
from .tissue import extent_of

ENOUGH = 4e-3  # m of clearance: more is not better
BEND = 0.1  # m of clearance that a metre between the straight line and the target costs: what bends is less certain
FORCE = 1e-4  # m of clearance that a newton costs
ON_SURFACE = 1e-6  # m
EVEN, STEEPEST = 3e-3, 3.0  # m around an entry, where the surface is not farther from it than so many times that
LOOK, LOOK_FOR = 2e-3, 5e-3  # m between the points of a straight way that are looked at; how far around them
SLIP = 4e-3  # m: a tip that enters farther from its line has slipped
MISS = 0.5  # likewise a metre of miss, which the next correction mends for the most part


@dataclasses.dataclass(frozen=True)
class Problem:
    """`target` (3,) m; `avoid`, of (name, Place); `entry_region`, a Place or None; `axis`, the scene's; `tilt`, how far a
    direction may be from that, rad, 0: it stays; `longest`, m that the needle can go in."""

    model: object
    surface: object
    target: np.ndarray
    avoid: tuple
    entry_region: object
    axis: np.ndarray
    tilt: float
    radius: float  # m, to hit within
    longest: float
    needle_radius: float
    walls: tuple = ()  # of (name, Place): what the needle shall not or cannot pass

    def allows(self, candidate):
        return (self.lies_in_entry_region(candidate.entry) and self.is_even(candidate.entry, candidate.direction)
                and np.arccos(np.clip(candidate.direction @ self.axis, -1, 1)) <= self.tilt + 1e-9)

    def lies_in_entry_region(self, point):
        return self.entry_region is None or bool(self.entry_region.distances(self.model, point)[0] <= ON_SURFACE)

    def is_even(self, entry, direction):
        """Whether the surface goes on for 3 mm to all sides, without an edge over which the tip could slip."""
        side = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
        side *= EVEN / np.linalg.norm(side)
        for beside in (side, -side, np.cross(direction, side), -np.cross(direction, side)):
            found = self.surface.hit(entry + beside, direction)
            if found is None or np.linalg.norm(found[0] - entry) > STEEPEST * EVEN:
                return False
        return True

    def corridor(self, entry):
        """m, from a needle that goes straight from an entry to the target to the nearest wall; where that is more than LOOK_FOR,
        so much at least. A negative number tells that it meets one, not how far it goes in."""
        steps = max(2, math.ceil(float(np.linalg.norm(self.target - entry)) / LOOK))
        points = entry + np.linspace(0, 1, steps + 1)[:, None] * (self.target - entry)
        nearest = math.inf
        for _, wall in self.walls:
            for part in np.array_split(wall.near(self.model, points, LOOK_FOR + self.needle_radius), 8):
                if nearest > 0 and len(part):
                    nearest = min(nearest, float(wall.distances(self.model, part).min()) - self.needle_radius)
        return nearest

    @property
    def extent(self):
        return extent_of(self.model)

    def clearances(self, points):
        """{name: m} of the needle along points at rest (n, 3)."""
        return clearances(self.model, self.avoid, points, self.needle_radius)


@dataclasses.dataclass(frozen=True)
class Candidate:
    entry: np.ndarray
    direction: np.ndarray
    turn: float = 0.0
    spin_rate: float = 0.0
    flips: tuple = ()
    stop: float = 0.0  # m, see Approach
    end: object = None  # Outcome, once it was simulated

    @property
    def kind(self):
        return "spun" if self.spin_rate else f"{len(self.flips)} flips"

    def values(self):
        """As parameters of a motion."""
        return {"entry": tuple(map(float, self.entry)), "direction": tuple(map(float, self.direction)), "turn": float(self.turn),
                "spin_rate": float(self.spin_rate), "flips": tuple(map(float, self.flips))}


@dataclasses.dataclass(frozen=True)
class Outcome:
    miss: np.ndarray  # m, from the tip to the target
    force: float  # N
    shaft: np.ndarray  # m, n x 3, at rest: the needle in the tissue
    cut: np.ndarray  # likewise, what its tip has cut
    clearance: dict
    depth: float  # m

    @classmethod
    def of(cls, row, prefix, avoid, depth=None):
        """Of a row of a study with the output Judged or JudgedEnds."""
        def value(name):
            return row[f"{prefix}.{name}"]
        lines = [np.array(json.loads(value(each))).reshape(-1, 3) for each in ("shaft", "cut")]
        return cls(np.array([value(f"miss.{axis}") for axis in "xyz"]), value("force"), *lines,
                   {name: value(f"clearance.{name}") for name, _ in avoid}, value("depth") if depth is None else depth)

    @property
    def margin(self):
        return min(self.clearance.values(), default=np.inf)

    def enters(self, entry, direction):
        """Whether it went in where it should."""
        if not len(self.cut):
            return False
        aside = np.cross(np.asarray(direction), self.cut[0] - entry)
        return float(np.linalg.norm(aside)) < SLIP


def score(problem, candidate):
    """m, larger is better."""
    end = candidate.end
    if not end.enters(candidate.entry, candidate.direction):
        return -1.0
    aside = np.cross(candidate.direction, problem.target - candidate.entry)
    return (min(end.margin, ENOUGH) - BEND * float(np.linalg.norm(aside)) - FORCE * end.force
            - MISS * max(0.0, float(np.linalg.norm(end.miss)) - problem.radius / 4))


def follow(problem, candidate, turn=0.0, entry=None, flips=None):
    """The candidate with its miss corrected, turned about its axis and moved to another entry, with the way that it should
    take; None where that is not allowed."""
    end = candidate.end
    tip = problem.target - end.miss  # as if the target lay at rest
    if problem.tilt:
        made = aimed(problem, candidate, tip, turn, candidate.entry if entry is None else entry)
    else:
        made = moved(problem, candidate, tip, turn)
    if made is None:
        return None
    stop = candidate.stop - float(end.miss @ candidate.direction)
    made = dataclasses.replace(made, stop=stop, flips=candidate.flips if flips is None else flips)
    rotation = rotation_between(problem, candidate, made)
    shaft, cut = (made.entry + rotate(rotation, each - candidate.entry) for each in (end.shaft, end.cut))
    clearance = problem.clearances(np.concatenate([shaft, cut]))
    return dataclasses.replace(made, end=Outcome(np.zeros(3), end.force, shaft, cut, clearance, end.depth))


def aimed(problem, candidate, tip, turn, entry):
    """From an entry into the direction in which it meets the target."""
    made = dataclasses.replace(candidate, entry=entry, direction=unit(problem.target - entry), turn=candidate.turn + turn)
    for _ in range(3):  # the bend turns with the direction
        arrived = rotate(rotation_between(problem, candidate, made), tip - candidate.entry)
        made = dataclasses.replace(made, direction=rotate(shortest_rotation(arrived, problem.target - entry), made.direction))
    return made if problem.allows(made) else None


def moved(problem, candidate, tip, turn):
    """In its direction, from the entry from which it meets the target."""
    made = dataclasses.replace(candidate, turn=candidate.turn + turn)
    arrived = candidate.entry + rotate(rotation_between(problem, candidate, made), tip - candidate.entry)
    shift = across(problem.target - arrived, candidate.direction)
    found = problem.surface.hit(candidate.entry + shift, candidate.direction)
    made = None if found is None else dataclasses.replace(made, entry=found[0])
    return made if made is not None and problem.allows(made) else None


def rotation_between(problem, before, after):
    """That takes the needle of one insertion, as it is without tissue, to that of another."""
    def frame(candidate):
        return multiply(rotation_about(candidate.direction, candidate.turn), shortest_rotation(problem.axis, candidate.direction))
    return multiply(frame(after), conjugate(frame(before)))


def across(vector, direction):
    return vector - (vector @ direction) * direction
