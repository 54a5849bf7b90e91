# SPDX-License-Identifier: MIT
"""Task `reach`: steer a bevel needle to a target in a gel, by how fast it goes in and how fast it spins.

The needle drifts towards where its bevel looks, so it goes straight only while it spins. Lengths are in units of 10 mm
in observations, so that they are about 1; frame: that of the base after loading (along, +y, +z).
"""

import math

import numpy as np

from ..errors import EnvError
from .. import rotation
from .interface import Box
from .scenes import steering
from .task import Outcome, Task
from .world import axial_resistance, unit

CM = 100  # per m
TICKS = 5  # of a step
FEED = 1e-3  # m of a step at most: 20 mm/s
TURN = 1.0  # rad of a step at most
TOLERANCE = 1e-3  # m from the target
BEYOND = 2e-3  # m past it: missed
ENTRY = 0.06  # m, z of the surface
DEPTHS = (0.06, 0.08)  # m below it, of targets
ASIDE = 8e-3  # m from the axis, at most


class Reach(Task):
    """Action: feed (0 to 1), spin (-1 to 1). Observation: see observe(). Reward: millimetres that the tip came nearer,
    10 at the target. Ends at the target (success) or past it."""

    name = "reach"
    steps = 150
    action_space = Box(np.array([0, -1], np.float32), np.array([1, 1], np.float32))
    observation_space = Box(-np.inf, np.inf, (10,))
    options = ("target",)  # m, world
    ranges = {"tissue.regions[0].material.young_modulus": (20e3, 45e3),
              "tissue.regions[0].interaction.cutting_force": (0.2, 0.4),
              "needles[0].cutting_direction[1]": (0.08, 0.15)}

    def scene(self):
        return steering()

    def check(self, options):
        target = np.array(options.get("target", [0, 0, 0]), dtype=float)
        if target.shape != (3,) or not np.all(np.isfinite(target)):
            raise EnvError(f"options: target: expected 3 finite numbers, found {options['target']}")

    def begin(self, world, random, options):
        self._needle = world.needles[0]
        angle, radius = random.uniform(0, 2 * math.pi), ASIDE * math.sqrt(random.uniform())
        drawn = [radius * math.cos(angle), radius * math.sin(angle), ENTRY - random.uniform(*DEPTHS)]
        self.target = np.array(options.get("target", drawn), dtype=float)
        self._heading = self._needle.axis
        self._tip = self._force(world).tip_position
        self._distance = np.linalg.norm(self.target - self._tip)

    def act(self, world, action):
        feed, turn = action
        name = self._needle.name
        world.drive(self._needle, world.depths[name] + FEED * float(feed), world.spins[name] + TURN * float(turn))
        world.step(TICKS)
        tip = self._force(world).tip_position
        self._heading = unit(tip - self._tip, self._heading)
        self._tip = tip

    def observe(self, world):
        """From the tip to the target (3, 10 mm), where the tip is heading (3, unit), cosine and sine of the spin, depth
        of the base (10 mm), axial resistance (N)."""
        to_base = rotation.conjugate(self._needle.base_orientation)
        spin = world.spins[self._needle.name]
        return np.concatenate([CM * rotation.rotate(to_base, self.target - self._tip),
                               rotation.rotate(to_base, self._heading), [math.cos(spin), math.sin(spin)],
                               [CM * world.depths[self._needle.name], axial_resistance(self._force(world))]])

    def judge(self, world):
        distance = np.linalg.norm(self.target - self._tip)
        nearer, self._distance = 1e3 * (self._distance - distance), distance
        success = distance < TOLERANCE
        missed = (self.target - self._tip) @ self._needle.axis < -BEYOND
        return Outcome(nearer + 10 * success, success or missed, success, {"distance": distance})

    def _force(self, world):
        return world.states[self._needle.name]


def policy(observation):
    """Turns the bevel towards where the target lies beside the way ahead, and spins on where that is straight ahead."""
    to_target, heading, spin = observation[:3], observation[3:6], math.atan2(observation[7], observation[6])
    aside = to_target - (to_target @ heading) * heading
    if np.linalg.norm(aside) < 0.02:  # 0.2 mm
        return np.array([1.0, 1.0])
    error = (math.atan2(aside[2], aside[1]) - spin + math.pi) % (2 * math.pi) - math.pi
    return np.array([1.0, np.clip(error / TURN, -1, 1)])
