# SPDX-License-Identifier: MIT
"""Task `force_limit`: push a needle through skin and fat into muscle, as fast as a limit of the force allows.

Friction along the shaft grows with speed and with depth, and each layer has to be pushed through.
"""

import numpy as np

from ..errors import EnvError
from .interface import Box
from .scenes import layers
from .task import Outcome, Task
from .world import axial_resistance

CM = 100  # per m
TICKS = 5  # of a step
FEED = 2.5e-3  # m of a step at most: 100 mm/s
LIMIT = 1.25  # N, of the axial resistance; at full feed it comes to 1.4 to 1.8 N
PATIENCE = 0.02  # that a step costs
DEPTH = 0.055  # m, of the tip below the skin: through all layers' borders


class ForceLimit(Task):
    """Action: feed (-1 to 1). Observation: see observe(). Reward: a tenth of the millimetres that the needle went in,
    less 0.02 a step, 10 at the goal, -10 for a force above the limit, which ends the episode. The largest force of any
    tick counts."""

    name = "force_limit"
    steps = 300
    action_space = Box(-1.0, 1.0, (1,))
    observation_space = Box(-np.inf, np.inf, (5,))
    options = ("limit",)  # N
    ranges = {"tissue.regions[skin].interaction.puncture_force": (0.7, 1.1),
              "tissue.regions[muscle].interaction.puncture_force": (0.5, 0.9),
              "tissue.regions[muscle].interaction.friction_viscous": (100, 250)}

    def scene(self):
        return layers()

    def check(self, options):
        limit = float(options.get("limit", LIMIT))
        if not 0 < limit < np.inf:
            raise EnvError(f"options: limit: expected a force (N) above 0, found {limit}")

    def begin(self, world, random, options):
        self._needle = world.needles[0]
        self.limit = float(options.get("limit", LIMIT))
        self._force = self._before = 0.0
        self._peak = 0.0
        self._feed = 0.0
        self._goal = DEPTH + 0.01  # it starts 10 mm above the skin

    def act(self, world, action):
        self._feed = float(action[0])
        depth = world.depths[self._needle.name] + FEED * self._feed
        world.drive(self._needle, max(0.0, depth))
        forces = [axial_resistance(states[self._needle.name]) for states in world.trace(TICKS)]
        self._before, self._force, self._peak = self._force, forces[-1], max(forces)

    def observe(self, world):
        """Depth of the base (10 mm), feed of the last step (-1 to 1), axial resistance (N), what it changed by in the
        step (N), the limit (N)."""
        return np.array([CM * world.depths[self._needle.name], self._feed, self._force, self._force - self._before,
                         self.limit])

    def judge(self, world):
        exceeded = self._peak > self.limit
        success = not exceeded and world.depths[self._needle.name] >= self._goal
        reward = 100 * FEED * self._feed - PATIENCE + 10 * success - 10 * exceeded
        return Outcome(reward, exceeded or success, success, {"force": self._force, "peak": self._peak})


def policy(observation):
    """As fast as the room below the limit allows, if the force goes on as it did in the step before."""
    _, feed, force, change, limit = observation
    room = limit - 0.05 - force - 2 * max(0.0, change)
    return np.array([np.clip(2 * room, -0.2, min(1.0, feed + 0.1))])
