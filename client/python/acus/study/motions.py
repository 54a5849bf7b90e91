# SPDX-License-Identifier: MIT
"""How needles move in the cases of a study. A policy is any function of a World; it commands and steps it. One that is a
dataclass has its fields as parameters of the study, `motion.NAME`, and may say by `bodies(model)` where needles begin."""

import dataclasses
import math
import os
import re

import numpy as np

from ..errors import StudyError
from ..rotation import axis_of, conjugate, multiply, rotate, rotation_about, shortest_rotation, unit
from .trajectory import Trajectory
from .values import any_inside, check_number, check_rising, check_vector
from .world import needle_of

ALONG, SIDE = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])  # of a needle's own frame
CLEARANCE = 5e-3  # m
LONGEST_WAY = 10.0  # m: no needle is longer
LOOKS = 100  # at places on the way of a base
HALF_TURN = 0.25  # s


@dataclasses.dataclass(frozen=True)
class Insertion:
    """A needle goes in along its axis at a steady speed, rests, and comes back if asked to.

    The tip begins `clearance` before `entry` and ends, if neither tissue nor needle gave way, `depth` behind it. At the end
    of each way it waits for the base, which a scene's `smoothing` lets lag behind, to have arrived.
    """

    depth: float  # m
    speed: float = 0.02  # m/s
    entry: tuple = None  # m, world; None: where the tip stands in the scene, and it begins there
    direction: tuple = None  # world, of any length, from base to tip; None: the scene's
    tilt: float = 0.0  # rad, from that direction
    azimuth: float = 0.0  # rad, about that direction: to which side it is tilted, 0: that of the needle's +y
    turn: float = 0.0  # rad, about its own axis, so that a bevel looks elsewhere
    spin_rate: float = 0.0  # rad/s, while it goes in
    flips: tuple = ()  # m behind the entry, rising: there it rests and makes half a turn, so that a bevel looks the other way
    clearance: float = CLEARANCE  # m, where an entry is given
    hold: float = 0.0  # s at the end of the way
    pull_back: bool = False  # at the same speed
    needle: str = None  # None: the first

    def __post_init__(self):
        for name in ("depth", "speed", "tilt", "azimuth", "turn", "spin_rate", "clearance", "hold"):
            check_number("motion." + name, getattr(self, name))
        for name, least in (("speed", 1e-6), ("depth", 0), ("clearance", 0), ("hold", 0)):
            if getattr(self, name) < least:
                raise StudyError(f"motion.{name}: expected at least {least}, found {getattr(self, name)}")
        for name in ("entry", "direction"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, check_vector("motion." + name, getattr(self, name)))
        object.__setattr__(self, "flips", check_rising("motion.flips", self.flips))
        if not isinstance(self.pull_back, (bool, np.bool_)):
            raise StudyError(f"motion.pull_back: expected True or False, found {self.pull_back!r}")
        if self.depth > LONGEST_WAY:
            raise StudyError(f"motion.depth: expected at most {LONGEST_WAY:g} m, found {self.depth}")
        if self.direction and not any(self.direction):
            raise StudyError("motion.direction: expected a direction, found zeros")

    def bodies(self, model):
        needle = needle_of(model.needles, self.needle)
        if self.entry is None and self.direction is None and not (self.tilt or self.turn):
            return {}
        tip = model.start().needle_positions(needle.name)[-1]
        entry, clearance = (tip, 0.0) if self.entry is None else (np.array(self.entry), self.clearance)
        turned = self._orientation(needle.base_orientation)
        from_tip = rotate(multiply(turned, conjugate(needle.base_orientation)), needle.base_position - tip)
        return {needle.name: (entry - clearance * axis_of(turned) + from_tip, turned)}

    def _orientation(self, scene):
        turned = multiply(shortest_rotation(axis_of(scene), self.direction), scene) if self.direction else scene
        along = axis_of(turned)
        towards = rotate(rotation_about(along, self.azimuth), rotate(turned, SIDE))
        turned = multiply(rotation_about(np.cross(along, towards), self.tilt), turned)
        return unit(multiply(turned, rotation_about(ALONG, self.turn)))

    def __call__(self, world):
        needle = world.needle(self.needle)
        way = self.way
        places = self.places(world)
        self.check_base(world, needle, way)
        for advance, spin in places:
            world.drive(needle, advance, spin)
            world.step()
        world.settle(needle)
        if self.hold:
            world.step(max(1, world.ticks_of(self.hold)))
        ticks = world.ticks_of(way / self.speed)
        for tick in range(ticks - 1, -1, -1) if self.pull_back else ():
            world.drive(needle, way * tick / ticks)
            world.step()
        if self.pull_back:
            world.settle(needle)

    @property
    def way(self):
        """m, of the base."""
        return self.depth + (0.0 if self.entry is None else self.clearance)

    def places(self, world):
        """[(advance in m, spin in rad or None)] of each tick of the way in."""
        ticks = world.ticks_of(self.way / self.speed)
        if not ticks:
            raise StudyError(f"motion: a way of {self.way} m at {self.speed} m/s takes less than a tick; change depth or speed")
        spins = bool(self.spin_rate or self.flips)
        turning = max(1, world.ticks_of(HALF_TURN))
        flips, turned, places = [self.way - self.depth + each for each in self.flips], 0.0, []
        for tick in range(1, ticks + 1):
            while flips and self.way * tick / ticks > flips[0]:
                at, spin = places[-1] if places else (0.0, 0.0)
                places += [(at, spin + math.pi * step / turning) for step in range(1, turning + 1)]
                turned += math.pi
                flips.pop(0)
            places.append((self.way * tick / ticks, turned + self.spin_rate * tick * world.time_step if spins else None))
        return places

    @staticmethod
    def check_base(world, needle, way):
        """Nothing holds a base inside the tissue: what came of it would mean nothing."""
        nodes = world.model.rest_positions
        if not len(nodes) or np.min(np.linalg.norm(nodes - needle.base_position, axis=1)) > way:
            return
        points = needle.base_position + np.linspace(0, way, LOOKS)[:, None] * needle.axis
        if any_inside(nodes, world.model.tetrahedra, points):
            raise StudyError(f"motion.depth: on a way of {way:g} m the base of '{needle.name}' would go into the tissue; the needle "
                             f"is {needle.length:g} m long")


# ---- What a study does with a policy ----


def motion_names(policy):
    """Of its fields that can be parameters."""
    if not dataclasses.is_dataclass(policy):
        return []
    return [field.name for field in dataclasses.fields(policy) if field.init and field.repr]


def with_values(policy, values):
    """The policy with other values of fields, {name: value}; a name may be that of a component, entry[0]."""
    fields = {}
    for place, value in values.items():
        name, component = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", place).groups()
        if component is None:
            fields[name] = value
            continue
        vector = fields.get(name, getattr(policy, name))
        if vector is None or int(component) >= len(vector):
            raise StudyError(f"motion.{place}: the motion has no such component; give it a whole {name} to begin with")
        fields[name] = tuple(value if i == int(component) else each for i, each in enumerate(vector))
    if isinstance(policy, Trajectory) and "path" in fields:
        fields["motions"] = None  # to be read
    return dataclasses.replace(policy, **fields) if fields else policy


def check_motion_name(policy, place):
    """Of a parameter `motion.PLACE`. Raises StudyError."""
    found = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", place)
    names = motion_names(policy)
    if not found or found[1] not in names:
        has = f"it has {', '.join(names)}" if names else "a function has none, a dataclass has its fields"
        raise StudyError(f"motion.{place}: the motion has no such parameter; {has}")


def policy_of(given):
    """Of what Study takes: a policy, or the path of a trajectory."""
    if isinstance(given, (str, os.PathLike)):
        return Trajectory(os.fspath(given))
    if not callable(given) or isinstance(given, type):
        raise StudyError(f"motion: expected an Insertion, a trajectory or a function of a World, found {given!r}")
    return given
