# SPDX-License-Identifier: MIT
"""A server in lockstep that begins again from the same state as often as an episode does."""

import numpy as np

from ..server import Server

PATIENCE = 60.0  # s for an answer: loading a scene may take a while
SETTLING = 2  # ticks before the state that every episode begins with


class World:
    """`client` talks to it, `states` are the newest. Needles go along their own axes: `depths` (m from where they stand
    after loading) and `spins` (rad), by name."""

    def __init__(self, scene, topics=("force",), **server):
        self.server = Server(scene, lockstep=True, **server)
        try:
            self.client = self.server.client(topics=topics, timeout=PATIENCE)
            self._prepare()
        except BaseException:
            self.server.end()
            raise

    def close(self):
        self.client.close()
        self.server.end()

    def load(self, scene):
        self.client.load(scene)
        self._prepare()

    def begin(self):
        """The start again, and one tick, so that there are states."""
        self.client.restore(self._start)
        self.depths = {needle.name: 0.0 for needle in self.client.needles}
        self.spins = dict(self.depths)
        self.step(1)

    def drive(self, needle, depth, spin=0.0):
        """Commands a depth (m) and a spin (rad); takes effect with the next step."""
        self.depths[needle.name], self.spins[needle.name] = depth, spin
        self.client.pose(needle, needle.base_position + depth * needle.axis, needle.base_orientation, spin)

    def step(self, ticks):
        self.states = self.client.step(ticks)

    def trace(self, ticks):
        """The States of each tick."""
        trace = self.client.trace(ticks)
        self.states = trace[-1]
        return trace

    def _prepare(self):
        self.client.step(SETTLING)
        self._start = self.client.snapshot().snapshot
        self.begin()


def axial_resistance(force):
    """N, what a hand feels along the needle; positive when the tissue resists going in."""
    return -float(force.base_force_in_base[0])


def unit(vector, otherwise, least=1e-4):
    """Of length 1, or `otherwise` where it is shorter than `least`."""
    length = np.linalg.norm(vector)
    return vector / length if length > least else otherwise
