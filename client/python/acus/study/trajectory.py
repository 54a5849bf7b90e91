# SPDX-License-Identifier: MIT
"""Recorded motions of needle bases, as acus-replay reads them (client/replay/trajectory.h)."""

import csv
import dataclasses

import numpy as np

from ..errors import StudyError
from ..rotation import slerp
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


def read_trajectory(path):
    """{needle: Motion}. Raises StudyError."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            header, *rows = list(csv.reader(line for line in file if line.strip() and not line.startswith("#"))) or [[]]
    except (OSError, ValueError) as error:
        raise StudyError(f"{path}: {getattr(error, 'strerror', error)}") from None
    header = [name.strip() for name in header]
    missing = [name for name in COLUMNS if name not in header]
    if missing or not rows:
        raise StudyError(f"{path}: not a trajectory: " + (f"no column '{missing[0]}'" if missing else "no rows"))
    if any(len(row) != len(header) for row in rows):
        raise StudyError(f"{path}: not a trajectory: a row has not {len(header)} cells")
    samples = {}
    for row in rows:
        samples.setdefault(row[header.index("needle")].strip(), []).append(row)
    return {needle: motion_of(path, needle, header, part) for needle, part in samples.items()}


def motion_of(path, needle, header, rows):
    def columns(*names):
        try:
            values = np.array([[float(row[header.index(name)]) for name in names] for row in rows])
        except ValueError as error:
            raise StudyError(f"{path}: needle '{needle}': {error}") from None
        if not np.all(np.isfinite(values)):
            raise StudyError(f"{path}: needle '{needle}': a number of column '{names[0]}' or after it is not finite")
        return values

    times, orientations = columns("t")[:, 0], columns("qw", "qx", "qy", "qz")
    if np.any(np.diff(times) <= 0):
        raise StudyError(f"{path}: needle '{needle}': times do not rise")
    lengths = np.linalg.norm(orientations, axis=1)
    if np.any(np.abs(lengths - 1) > 1e-3):
        raise StudyError(f"{path}: needle '{needle}': an orientation is no unit quaternion")
    spins = columns("spin")[:, 0] if "spin" in header else None
    return Motion(times, columns("x", "y", "z"), orientations / lengths[:, None], spins)
