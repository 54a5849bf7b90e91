# SPDX-License-Identifier: MIT
"""What a policy drives: one run of a scene on the engine."""

import copy
import math
import operator
import time

import numpy as np

from .. import engine
from ..errors import StudyError
from ..rotation import conjugate, multiply, rotate

LONGEST = 10_000_000  # ticks of a case
SETTLING = 0.5  # s
AT_REST, TURNED = 1e-4, 0.1  # m/s, rad/s


class World:
    """`needles` and `guides` as in `hello`, where this run begins; `parameters` of the case, {name: value}; `random`, a
    numpy Generator of the case's seed; `report`, of the newest tick, at first of the start; `model` and `state` of
    acus.engine."""

    def __init__(self, model, parameters=None, seed=0, bodies=None):
        """`bodies`: {name: (position, orientation)}, of those that begin elsewhere than in the scene. The guides of a
        needle go with it, unless they are named, too."""
        self.model, self.parameters, self.random = model, dict(parameters or {}), np.random.default_rng(seed)
        self.rate, self.time_step = model.rate, model.time_step
        bodies = with_guides(model, bodies or {})
        self.state = model.start(bodies)
        self.needles = [placed(each, "base_position", "base_orientation", bodies) for each in model.needles]
        self.guides = [placed(each, "position", "orientation", bodies) for each in model.guides]
        self._axes = {each.name: each.axis for each in self.needles}
        self.report = self.state.report
        self.old_paths = len(self.state.paths)  # that were there before anything moved
        self.reports, self.tick_times, self.notes = [], [], {}  # of each tick; s, of each
        self._commands = {}
        self._told = {each.name: (each.base_position, each.base_orientation) for each in self.needles}
        self._told.update({each.name: (each.position, each.orientation) for each in self.guides})

    @property
    def time(self):
        """s, of the newest tick."""
        return self.state.time

    def needle(self, name=None):
        """By name, without one the first. Raises StudyError."""
        return needle_of(self.needles, name)

    def pose(self, body, position, orientation=None, spin=None):
        """Commands the base of a needle, or a guide, from the next tick on; without an orientation (w, x, y, z) the last
        one stays. `spin` in rad."""
        name = getattr(body, "name", body)
        if name not in self._told:
            raise StudyError(f"the scene has no needle or guide '{name}'; it has {', '.join(self._told)}")
        orientation = self._told[name][1] if orientation is None else orientation
        self._told[name] = (position, orientation)
        self._commands[name] = (position, orientation) if spin is None else (position, orientation, spin)

    def drive(self, needle, advance, spin=None):
        """Commands a needle, or its name, along its own axis: `advance` (m) from where it began."""
        needle = self.needle(needle) if isinstance(needle, str) else needle
        self.pose(needle, needle.base_position + advance * self._axes[needle.name], needle.base_orientation, spin)

    def step(self, ticks=1):
        """The report of the last of so many ticks."""
        ticks = operator.index(ticks)
        if len(self.reports) + ticks > LONGEST:
            raise StudyError(f"a case of more than {LONGEST} ticks")
        begin = time.perf_counter()
        commands, self._commands = self._commands, {}
        self.reports += self.state.trace(commands, ticks)
        self.tick_times += [(time.perf_counter() - begin) / ticks] * ticks
        self.report = self.reports[-1]
        return self.report

    def branch(self):
        """Another World that goes on from here: what is done with one, the other does not see."""
        other = copy.copy(self)
        other.state, other.random = self.state.copy(), copy.deepcopy(self.random)
        other.reports, other.tick_times, other.notes = list(self.reports), list(self.tick_times), dict(self.notes)
        other._commands, other._told = dict(self._commands), dict(self._told)
        return other

    def settle(self, needle):
        """Steps until the base has come to rest after its last command, and no longer turns; half a second at most."""
        before = self.report[needle.name]
        for _ in range(self.ticks_of(SETTLING)):
            now = self.step()[needle.name]
            moved, turned = np.linalg.norm(now.base_position - before.base_position), abs(now.spin - before.spin)
            if moved * self.rate < AT_REST and turned * self.rate < TURNED:
                break
            before = now

    def ticks_of(self, seconds):
        return max(0, round(seconds * self.rate)) if math.isfinite(seconds) else LONGEST + 1


def needle_of(needles, name):
    """By name, without one the first. Raises StudyError."""
    found = next((each for each in needles if name in (None, each.name)), None)
    if found is None:
        raise StudyError(f"the scene has no needle '{name}'; it has {', '.join(each.name for each in needles)}")
    return found


def placed(body, position, orientation, bodies):
    body = copy.copy(body)
    if body.name in bodies:
        setattr(body, position, np.asarray(bodies[body.name][0], dtype=float))
        setattr(body, orientation, np.asarray(bodies[body.name][1], dtype=float))
    return body


def with_guides(model, bodies):
    """Guides of needles that begin elsewhere are moved alike, so that the needle is in them as before."""
    every = dict(bodies)
    for needle in model.needles:
        for guide in model.guides:
            if needle.name in bodies and guide.needle == needle.name:
                position, orientation = bodies[needle.name]
                turn = multiply(orientation, conjugate(needle.base_orientation))
                every.setdefault(guide.name, (position + rotate(turn, guide.position - needle.base_position),
                                              multiply(turn, guide.orientation)))
    return every
