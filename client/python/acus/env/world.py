# SPDX-License-Identifier: MIT
"""What an environment runs in: a scene that begins again from the same state as often as an episode does. In this
process, by acus.engine, or in a server in lockstep; both give the same bytes."""

import difflib
import inspect

import numpy as np

from .. import engine
from ..errors import EnvError
from ..server import Server

PATIENCE = 60.0  # s for an answer: loading a scene may take a while
SETTINGS = set(inspect.signature(Server).parameters) - {"scene", "lockstep"}  # of a server, that an environment takes
SETTLING = 2  # ticks before the state that every episode begins with


def make_world(scene, topics=("force",), on=None, **server):
    """A World. `on`: "engine", "server", or None for the engine where it is and nothing is asked of a server."""
    if on not in (None, "engine", "server"):
        raise EnvError(f"on: expected 'engine' or 'server', found '{on}'")
    if on == "engine" and server:
        raise EnvError(f"the engine takes no arguments of Server, found {', '.join(server)}")
    if unknown := sorted(set(server) - SETTINGS):
        close = difflib.get_close_matches(unknown[0], [*SETTINGS, "randomise", "on"], 1)
        raise EnvError(f"no argument '{unknown[0]}'; " + (f"did you mean '{close[0]}'?" if close else
                                                          f"those of Server are {', '.join(sorted(SETTINGS))}"))
    return EngineWorld(scene) if is_on_engine(on, server) else ServerWorld(scene, topics, **server)


def is_on_engine(on, server):
    """Whether make_world() takes the engine for these arguments of Server."""
    return on == "engine" or (on is None and not server and engine.available())


class World:
    """`states` are the newest. Needles go along their own axes: `depths` (m from where they stand after loading) and
    `spins` (rad), by name. `needles`, `guides` and `rate` as in `hello`."""

    def begin(self):
        """The start again, and one tick, so that there are states."""
        self._restore()
        self.depths = {needle.name: 0.0 for needle in self.needles}
        self.spins = dict(self.depths)
        self.step(1)

    def drive(self, needle, depth, spin=0.0):
        """Commands a depth (m) and a spin (rad); takes effect with the next step."""
        self.depths[needle.name], self.spins[needle.name] = depth, spin
        self._command(needle, needle.base_position + depth * needle.axis, needle.base_orientation, spin)

    def load(self, scene):
        raise NotImplementedError

    def step(self, ticks):
        raise NotImplementedError

    def trace(self, ticks):
        """The states of each tick."""
        raise NotImplementedError

    def describe(self):
        """With `positions`, `tetrahedra` and more of the tissue at rest, as `describe_reply` has them."""
        raise NotImplementedError

    def close(self):
        pass

    def _restore(self):
        raise NotImplementedError

    def _command(self, needle, position, orientation, spin):
        raise NotImplementedError


class ServerWorld(World):
    """`client` talks to a server of its own."""

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

    def step(self, ticks):
        self.states = self.client.step(ticks)

    def trace(self, ticks):
        trace = self.client.trace(ticks)
        self.states = trace[-1]
        return trace

    def describe(self):
        return self.client.describe()

    def _restore(self):
        self.client.restore(self._start)

    def _command(self, needle, position, orientation, spin):
        self.client.pose(needle, position, orientation, spin)

    def _prepare(self):
        self.needles, self.guides, self.rate = self.client.needles, self.client.hello.guides, self.client.hello.rate
        self.client.step(SETTLING)
        self._start = self.client.snapshot().snapshot
        self.begin()


class EngineStates:
    """The report of a tick by the names of the wire: of a needle by its name, `tick`, `events`, `tissue.positions`."""

    def __init__(self, report, state):
        self._report, self._state = report, state
        self.tick, self.events = report.tick, report.events

    def __getitem__(self, needle):
        return self._report[needle]

    @property
    def tissue(self):
        """Of the newest tick."""
        return EngineTissue(self._state)


class EngineTissue:
    """With single precision, as the wire has it."""

    def __init__(self, state):
        self.positions = state.tissue_positions.astype(np.float32)


class EngineDescription:
    def __init__(self, model):
        self.positions = model.rest_positions.astype(np.float32)
        self.tetrahedra, self.tetrahedron_regions = model.tetrahedra, model.tetrahedron_regions
        self.regions = model.regions


class EngineWorld(World):
    """`model` and `state` are those of acus.engine."""

    def __init__(self, scene):
        self.load(scene)

    def load(self, scene):
        self.model = engine.load(scene)
        self.needles, self.guides, self.rate = self.model.needles, self.model.guides, self.model.rate
        self._start = self.model.start()
        engine.step(self.model, self._start, ticks=SETTLING)
        self.begin()

    def step(self, ticks):
        self.states = EngineStates(engine.step(self.model, self.state, self._take_commands(), ticks), self.state)

    def trace(self, ticks):
        trace = [EngineStates(report, self.state) for report in self.state.trace(self._take_commands(), ticks)]
        self.states = trace[-1]
        return trace

    @property
    def client(self):
        raise AttributeError("a world on the engine has no client; make the environment with on='server'")

    def describe(self):
        return EngineDescription(self.model)

    def _restore(self):
        self.state = self._start.copy()
        self._commands = {}

    def _command(self, needle, position, orientation, spin):
        self._commands[needle.name] = (position, orientation, spin)

    def _take_commands(self):
        commands, self._commands = self._commands, {}
        return commands


def axial_resistance(force):
    """N, what a hand feels along the needle; positive when the tissue resists going in."""
    return -float(force.base_force_in_base[0])


def unit(vector, otherwise, least=1e-4):
    """Of length 1, or `otherwise` where it is shorter than `least`."""
    length = np.linalg.norm(vector)
    return vector / length if length > least else otherwise
