# SPDX-License-Identifier: MIT
"""Task `needle_order`: in which order do six needles go into a prostate, so that the one that matters meets its target?

Each needle has a target, a place of the tissue. It is pushed in as deep as its target stands at that moment, as under
ultrasound. Every needle drags the prostate with it, and so moves the targets of those that stand already.
"""

import numpy as np

from ..errors import EnvError
from ..tissue_points import TissuePoints
from .interface import Box, Discrete
from .scenes import brachytherapy
from .task import Outcome, Task

CM = 100  # per m
NEEDLES = 6
SPEED = 0.1  # m/s
REST = 30  # ticks after a needle
DEPTHS = (0.05, 0.05, 0.05, 0.05, 0.05, 0.043)  # m below the skin, of the targets
SKIN = 0.04  # m, z
TOLERANCE = 1.6e-3  # m; 2.0 to 2.9 mm for a needle that went in first, 0.8 to 1.4 mm for one that went in last


class NeedleOrder(Task):
    """Action: which needle goes in next (0 to 5); one that stands already costs 1 and changes nothing. Reward at the
    end: -1 for each millimetre that the chosen needle's tip is from its target. Success: less than 1.6 mm."""

    name = "needle_order"
    topics = ("force", "tissue")
    steps = 12
    action_space = Discrete(NEEDLES)
    observation_space = Box(-np.inf, np.inf, (5 * NEEDLES,))
    options = ("chosen",)
    ranges = {"tissue.regions[tissue].material.young_modulus": (8e3, 14e3),
              "tissue.regions[prostate].material.young_modulus": (25e3, 40e3),
              "tissue.regions[prostate].interaction.puncture_force": (1.6, 2.2)}

    def scene(self):
        return brachytherapy()

    def check(self, options):
        if not self.action_space.contains(options.get("chosen", 0)):
            raise EnvError(f"options: chosen: expected an integer from 0 to {NEEDLES - 1}, found {options['chosen']}")

    def begin(self, world, random, options):
        self._needles = world.needles
        self.chosen = options.get("chosen", int(random.integers(NEEDLES)))
        self.inserted = np.zeros(NEEDLES, dtype=bool)
        described = world.describe()
        places = [[*needle.base_position[:2], SKIN - depth] for needle, depth in zip(self._needles, DEPTHS)]
        self._targets = TissuePoints(described, np.array(places))
        self.targets = self._targets.at(described.positions)
        self._repeated = False

    def act(self, world, action):
        index = action
        self._repeated = bool(self.inserted[index])
        if self._repeated:
            return
        needle = self._needles[index]
        depth = needle.tip_position[2] - self.targets[index, 2]
        ticks = int(np.ceil(depth / SPEED * world.rate))
        for tick in range(1, ticks + 1):
            world.drive(needle, depth * tick / ticks)
            world.step(1)
        world.step(REST)
        self.inserted[index] = True
        self.targets = self._targets.at(world.states.tissue.positions)

    def observe(self, world):
        """For each needle: whether it stands (0 or 1), whether it is the chosen one (0 or 1), and from its tip to its
        target (3, 10 mm, world)."""
        chosen = np.arange(NEEDLES) == self.chosen
        return np.column_stack([self.inserted, chosen, CM * self._misses(world)]).ravel()

    def judge(self, world):
        if self._repeated:
            return Outcome(-1.0, False, False, {})
        if not np.all(self.inserted):
            return Outcome(0.0, False, False, {})
        misses = np.linalg.norm(self._misses(world), axis=1)
        miss = misses[self.chosen]
        return Outcome(-1e3 * miss, True, bool(miss < TOLERANCE), {"miss": miss, "misses": misses})

    def _misses(self, world):
        tips = np.array([world.states[needle.name].tip_position for needle in self._needles])
        return self.targets - tips


def policy(observation):
    """The chosen needle last: what the others move is moved by then."""
    inserted, chosen = observation.reshape(NEEDLES, 5)[:, :2].T
    others = np.flatnonzero((inserted == 0) & (chosen == 0))
    return int(others[0] if others.size else np.argmax(chosen))
