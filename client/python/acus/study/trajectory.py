# SPDX-License-Identifier: MIT
"""Recorded motions of needle bases, as acus-replay reads them (client/replay/trajectory.h)."""

import dataclasses
import math

import numpy as np

from ..errors import StudyError
from ..rotation import slerp
from ..table import number_of, read_table
from .values import check_vector


@dataclasses.dataclass(frozen=True)
class Trajectory:
    """A CSV file with columns t, needle, x, y, z, qw, qx, qy, qz and optionally spin. In lockstep acus-replay gives the
    same ticks. `shift` moves all of it, and where its needles begin."""

    path: str
    shift: tuple = (0.0, 0.0, 0.0)  # m, world
    motions: dict = dataclasses.field(default=None, repr=False)  # of the file

    def __post_init__(self):
        object.__setattr__(self, "shift", check_vector("motion.shift", self.shift))
        if self.motions is None:
            object.__setattr__(self, "motions", read_trajectory(self.path))

    def bodies(self, model):
        everything = [each.name for each in [*model.needles, *model.guides]]
        for name in self.motions:
            if name not in everything:
                raise StudyError(f"{self.path}: the scene has no needle or guide '{name}'; it has {', '.join(everything)}")
        moved = [each for each in model.needles if any(self.shift) and each.name in self.motions]
        return {each.name: (each.base_position + self.shift, each.base_orientation) for each in moved}

    def __call__(self, world):
        begin = min(each.times[0] for each in self.motions.values())
        end = max(each.times[-1] for each in self.motions.values())
        world.step()  # acus-replay looks at a tick before it begins
        for tick in range(world.ticks_of(end - begin) + 1):
            for name, motion in self.motions.items():
                position, orientation, spin = motion.at(begin + tick * world.time_step)
                world.pose(name, position + self.shift, orientation, spin)
            world.step()


class Motion:
    """Samples of one body: times (n,), positions (n, 3), orientations (n, 4), spins (n,) or None."""

    def __init__(self, times, positions, orientations, spins):
        self.times, self.positions, self.orientations, self.spins = times, positions, orientations, spins

    def at(self, time):
        """Position and spin run straight between samples, the orientation along the shortest arc; at rest before the
        first and after the last."""
        right = int(np.clip(np.searchsorted(self.times, time, side="right"), 1, len(self.times) - 1))
        left = right - 1 if len(self.times) > 1 else 0
        right = min(right, len(self.times) - 1)
        span = self.times[right] - self.times[left]
        share = float(np.clip((time - self.times[left]) / span, 0, 1)) if span > 0 else 0.0
        position = (1 - share) * self.positions[left] + share * self.positions[right]
        spin = None if self.spins is None else float((1 - share) * self.spins[left] + share * self.spins[right])
        return position, slerp(self.orientations[left], self.orientations[right], share), spin


COLUMNS = ("t", "needle", "x", "y", "z", "qw", "qx", "qy", "qz")
NOT_FINITE = ("nan", "inf", "infinity")


def read_trajectory(path):
    """{needle: Motion}. Raises StudyError."""
    table = read_table(path, StudyError)
    missing = [name for name in COLUMNS if name not in table.header]
    if missing or not table.rows:
        raise StudyError(f"{path}: not a trajectory: " + (f"no column '{missing[0]}'; it has {', '.join(table.header)}" if missing else "no rows"))
    places = {name: table.column(name) for name in [*COLUMNS, "spin"] if name in table.header}
    comma = table.has_decimal_comma([place for name, place in places.items() if name != "needle"])
    samples = {}
    for line, row in zip(table.lines, table.rows):
        if len(row) != len(table.header):
            raise StudyError(f"{path}:{line}: not a trajectory: {len(row)} cells, not {len(table.header)} cells as in its header")
        numbers = {name: number_at(path, line, name, row[place], comma) for name, place in places.items() if name != "needle"}
        samples.setdefault(row[places["needle"]], []).append((line, numbers))
    return {needle: motion_of(path, needle, part) for needle, part in samples.items()}


def number_at(path, line, name, cell, comma):
    value = number_of(cell, comma)
    if math.isnan(value):
        raise StudyError(f"{path}:{line}: {name}: '{cell}' is not finite" if cell.lower().strip("+-") in NOT_FINITE else
                         f"{path}:{line}: {name}: could not convert '{cell}' to a number")
    return value


def motion_of(path, needle, samples):
    """Of [(line, {column: number})]."""
    def columns(*names):
        return np.array([[numbers[name] for name in names] for _, numbers in samples])

    times, orientations = columns("t")[:, 0], columns("qw", "qx", "qy", "qz")
    back = np.flatnonzero(np.diff(times) <= 0)
    if len(back):
        raise StudyError(f"{path}:{samples[back[0] + 1][0]}: needle '{needle}': times do not rise")
    lengths = np.linalg.norm(orientations, axis=1)
    wrong = np.flatnonzero(np.abs(lengths - 1) > 1e-3)
    if len(wrong):
        raise StudyError(f"{path}:{samples[wrong[0]][0]}: needle '{needle}': an orientation is no unit quaternion")
    spins = columns("spin")[:, 0] if "spin" in samples[0][1] else None
    return Motion(times, columns("x", "y", "z"), orientations / lengths[:, None], spins)
