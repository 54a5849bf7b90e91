# SPDX-License-Identifier: MIT
"""What the server says, as objects with typed fields; protocol/README.md is the contract, with every field's meaning.

Each class lists its fields once; the annotation says how a field arrives. Vectors and packed arrays become numpy
arrays. SI units, world frame unless a name says otherwise.
"""

from typing import Annotated, get_type_hints

import msgpack
import numpy as np

from .errors import ProtocolMismatch
from .rotation import axis_of

VERSION = 2

# kFlagNames of protocol/enums.h: what the bits of `flags` mean.
FLAG_NAMES = ("laws_not_converged", "newton_not_converged", "tangent_projected", "rows_dropped", "path_full",
              "not_finite", "solver_fell_back", "steps_capped", "iterations_capped", "publishing_reduced",
              "step_limited", "elements_inverted", "tip_found_inside", "forces_unbalanced", "shaft_unheld",
              "energy_gained", "needle_overstrained", "base_limited")


def flag_names(flags):
    """The names of the bits that are set, unknown ones left out."""
    return [name for bit, name in enumerate(FLAG_NAMES) if flags >> bit & 1]


def array_of(size):
    def convert(value):
        array = np.array(value, dtype=float)
        if array.shape != (size,):
            raise ValueError(f"expected {size} numbers")
        return array
    return convert


def packed(kind, columns=None):
    """Of bytes: rows x columns, or a plain array. Not to be written to."""
    def convert(value):
        array = np.frombuffer(value, kind)
        return array.reshape(-1, columns) if columns else array
    return convert


def list_of(kind):
    return lambda value: [kind(each) for each in value]


array_of_3, array_of_4 = array_of(3), array_of(4)
Vector = Annotated[np.ndarray, array_of_3]
Quaternion = Annotated[np.ndarray, array_of_4]  # w, x, y, z
Points = Annotated[np.ndarray, packed("<f8", 3)]  # n x 3
Quaternions = Annotated[np.ndarray, packed("<f8", 4)]  # n x 4
SinglePoints = Annotated[np.ndarray, packed("<f4", 3)]  # n x 3, single precision
Indices = Annotated[np.ndarray, packed("<i4")]
Triangles = Annotated[np.ndarray, packed("<i4", 3)]
Pairs = Annotated[np.ndarray, packed("<f4", 2)]  # n x 2, single precision
Matrix6 = Annotated[np.ndarray, packed("<f8", 6)]
Tetrahedra = Annotated[np.ndarray, packed("<i4", 4)]


COMPONENTS = {array_of_3: "xyz", array_of_4: "wxyz"}


def array_fields(message):
    """The components, xyz or wxyz, of the vectors and quaternions among a class's fields."""
    return {name: COMPONENTS[convert] for name, convert in message.converters if convert in COMPONENTS}


def as_it_is(value):
    return value


# Of a field that arrives as it is: the types that it may have.
PLAIN = {float: (float, int), int: (int,), str: (str,), bool: (bool,), list: (list,), bytes: (bytes,)}


class Message:
    """Made of the map that arrives. Fields that the class does not know are left out, missing ones are a mismatch."""

    def __init_subclass__(cls):
        hints = get_type_hints(cls, include_extras=True)
        cls.converters = [(name, hint.__metadata__[0] if hasattr(hint, "__metadata__") else as_it_is)
                          for name, hint in hints.items() if name not in cls.OPTIONAL]
        cls.plain = [(name, PLAIN[hint]) for name, hint in hints.items() if hint in PLAIN and name not in cls.OPTIONAL]

    OPTIONAL = {}  # fields that may be absent, and what they are then

    def __init__(self, message):
        fields = self.__dict__
        try:
            for name, convert in self.converters:
                fields[name] = convert(message[name])
        except (KeyError, TypeError, ValueError) as error:
            raise ProtocolMismatch(f"{type(self).__name__}: field '{name}' is missing or of another kind: {error}"
                                   ) from error
        for name, default in self.OPTIONAL.items():
            fields[name] = message.get(name, default)

    @classmethod
    def checked(cls, message):
        """As the constructor, and numbers, texts and lists have to be such: for what nobody vouches for."""
        made = cls(message)
        made.check_kinds()
        return made

    def check_kinds(self):
        for name, kinds in self.plain:
            if type(self.__dict__[name]) not in kinds:
                raise ProtocolMismatch(f"{type(self).__name__}: field '{name}' is of another kind: "
                                       f"{type(self.__dict__[name]).__name__}")
        for value in self.__dict__.values():
            for part in value if isinstance(value, list) else [value]:
                if isinstance(part, Message):
                    part.check_kinds()

    @classmethod
    def field_names(cls):
        return [name for name, _ in cls.converters]

    def __repr__(self):
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self.__dict__.items())})"


# ---- Answers ----


class Needle(Message):
    name: str
    length: float  # m
    diameter: float  # m, outer
    nodes: int
    base_position: Vector  # m, after loading
    base_orientation: Quaternion  # world from base, after loading
    cutting_direction: Vector  # unit, in the frame of the tip, whose axis is +x
    hub_diameter: float  # m, of the face at the base that a surface stops

    OPTIONAL = {"hub_diameter": 0.0}

    @property
    def axis(self):
        """Unit vector from the base along the needle, after loading."""
        return axis_of(self.base_orientation)

    @property
    def tip_position(self):
        """m, of a straight needle after loading."""
        return self.base_position + self.length * self.axis


class Guide(Message):
    name: str
    needle: str  # that slides in it
    position: Vector  # m, of the hole after loading
    orientation: Quaternion  # world from guide, after loading


class TissueSize(Message):
    nodes: int
    tetrahedra: int
    triangles: int


class Topic(Message):
    name: str
    rate: float  # Hz


class HelloReply(Message):
    server: str  # version
    oldest_version: int  # of the protocol, that the server speaks
    newest_version: int
    instance: int  # of this start of the server
    requests: list
    scene: str
    epoch: int
    rate: float  # Hz
    time_step: float  # s
    lockstep: bool
    paused: bool
    needles: Annotated[list, list_of(Needle)]
    guides: Annotated[list, list_of(Guide)]
    held: list
    tissue: Annotated[TissueSize, TissueSize]
    topics: Annotated[list, list_of(Topic)]
    OPTIONAL = {"recording": None, "file": None}


class NeedleAtRest(Message):
    name: str
    positions: Points  # m, nodes x 3


class DescribeReply(Message):
    epoch: int
    positions: SinglePoints  # m, nodes x 3, at rest
    triangles: Triangles  # triangles x 3, counter-clockwise seen from outside
    tetrahedra: Tetrahedra  # tetrahedra x 4
    regions: list
    region_colours: list  # "#rrggbb", or "" where the scene gives none
    tetrahedron_regions: Indices  # tetrahedra
    needles: Annotated[list, list_of(NeedleAtRest)]


class Done(Message):
    epoch: int
    tick: int
    time: float  # s


class HashReply(Done):
    hash: int


class SnapshotReply(HashReply):
    snapshot: bytes


class Holding(Message):
    epoch: int
    needles: list


# ---- States ----


class Force(Message):
    epoch: int
    tick: int
    time: float  # s, simulation time
    needle: str
    seq: int
    age: float  # s
    echo: float  # s, on the commanding client's clock
    fresh: float
    lost: int
    reordered: int
    limited: int
    stale: bool
    phase: str
    depth: float  # m
    unheld: float  # m
    base_position: Vector  # m
    base_orientation: Quaternion  # world from base
    commanded_position: Vector  # m
    commanded_orientation: Quaternion  # world from base, spin left out
    spin: float  # rad
    tip_position: Vector  # m
    tip_force: Vector  # N
    base_force: Vector  # N, by the needle on its holder
    base_torque: Vector  # N m
    base_force_in_base: Vector  # N, base frame
    base_torque_in_base: Vector  # N m, base frame
    haptic_force: Vector  # N
    haptic_torque: Vector  # N m
    cutting_force: Vector  # N
    friction_force: Vector  # N
    lateral_force: Vector  # N
    guide_force: Vector  # N
    needle_force: Vector  # N
    solver: str
    flags: int


class NeedleShape(Message):
    epoch: int
    tick: int
    time: float  # s
    needle: str
    positions: Points  # m, nodes x 3
    orientations: Quaternions  # nodes x 4, world from node


class TissueShape(Message):
    epoch: int
    tick: int
    time: float  # s
    positions: SinglePoints  # m, nodes x 3
    path_points: SinglePoints  # m, points x 3
    path_sizes: Indices  # paths
    dent_centres: SinglePoints  # m, dents x 3: see acus.Dents
    dent_moves: SinglePoints  # m, dents x 3
    dent_radii: Pairs  # m, dents x 2

    @property
    def paths(self):
        """Each path, m, points x 3."""
        return np.split(self.path_points, np.cumsum(self.path_sizes)[:-1]) if self.path_sizes.size else []


class Haptics(Message):
    epoch: int
    tick: int
    time: float  # s
    needle: str
    seq: int
    age: float  # s
    echo: float  # s
    stale: bool
    position: Vector  # m
    orientation: Quaternion  # world from base, without spin
    spin: float  # rad
    force: Vector  # N
    torque: Vector  # N m
    stiffness: Matrix6  # d(force, torque)/d(translation, rotation vector), 6 x 6
    forward: float  # m
    backward: float  # m
    forward_limit: str
    backward_limit: str
    lasting_force: Vector  # N
    lasting_torque: Vector  # N m
    forward_yield: float  # N
    backward_yield: float  # N
    flags: int


class Event(Message):
    epoch: int
    tick: int
    time: float  # s
    needle: str
    kind: str
    region: str
    position: Vector  # m
    force: float  # N


class Stats(Message):
    epoch: int
    tick: int
    time: float  # s
    period: float  # s
    paused: bool
    ticks: int
    tick_p50: float  # s, this one and the eight below
    tick_p99: float
    tick_max: float
    late: int
    wake_p50: float
    wake_p99: float
    wake_max: float
    end_p50: float
    end_p99: float
    end_max: float
    residual: float  # N
    sweeps: int
    newton_iterations: int
    rows: int
    imbalance: float  # N
    largest_force: float  # N
    hash_tick: int
    hash: int
    flags: int
    overruns: int
    rejected: int
    dropped: int
    recording: str
    subscribed: list


class States(dict):
    """The forces after a tick: Force by the name of the needle. `events` are those that came since the States before,
    `shapes` (NeedleShape by needle), `tissue` (TissueShape) and `haptics` (Haptics by needle) the newest that have come,
    if they are subscribed to."""

    def __init__(self, forces, events=(), shapes=None, tissue=None, standing=None, haptics=None):
        """`standing` tells epoch, tick and time where there are no forces."""
        super().__init__(forces)
        standing = next(iter(forces.values()), standing)
        self.epoch, self.tick, self.time = standing.epoch, standing.tick, standing.time
        self.events = list(events)
        self.shapes = dict(shapes or {})
        self.tissue = tissue
        self.haptics = dict(haptics or {})


def decode(payload):
    """The map of a message; raises ProtocolMismatch."""
    try:
        message = msgpack.unpackb(payload)
        if isinstance(message, dict) and isinstance(message.get("type"), str):
            return message
    except (ValueError, msgpack.UnpackException) as error:
        raise ProtocolMismatch(f"not a message of this protocol: {error}") from error
    raise ProtocolMismatch("not a message of this protocol: expected a map with a type")


def encode(kind, **fields):
    """Numbers of numpy and arrays may stand in fields; those that are None are left out."""
    message = {"v": VERSION, "type": kind}
    message.update((name, value) for name, value in fields.items() if value is not None)
    return msgpack.packb(message)
