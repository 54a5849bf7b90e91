#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Turns a recording of a hand-held tool into a trajectory for acus-replay.

The recording has no header and a row per sample: x y z [mm] qw qx qy qz. The whole motion is turned as one rigid body
so that its principal way, from the first sample to the one farthest from it, runs along --direction, then scaled, and
moved so that the base starts at --start. The needle turns as the tool turned, and points along --direction where the
tool had its mean orientation; --turn 0 keeps it there, --turn 0.5 halves its turns.
Trajectory: SI units, world frame; the needle lies along its base's +x axis.
"""

import argparse
import math
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "python"))

from acus import own_files  # noqa: E402
from acus.errors import AcusError  # noqa: E402
from acus.rotation import conjugate, multiply, rotate, shortest_rotation, unit  # noqa: E402

MM = 1e-3  # m
COLUMNS = ["t", "needle", "x", "y", "z", "qw", "qx", "qy", "qz", "spin"]


def read_recording(path):
    """[(position (m), unit quaternion)] of the rows; exits with file and line at the first bad one."""
    samples = []
    with open(path, encoding="ascii") as file:
        for number, line in enumerate(file, 1):
            if not line.strip():
                continue
            try:
                values = [float(cell) for cell in line.split()]
                if len(values) != 7 or not all(map(math.isfinite, values)):
                    raise ValueError("expected 7 finite numbers: x y z [mm] qw qx qy qz")
                samples.append((MM * np.array(values[:3]), unit(values[3:])))
            except ValueError as error:
                sys.exit(f"{path}:{number}: {error}")
    if not samples:
        sys.exit(f"{path}: no samples")
    return samples


def principal_way(samples):
    """From the first sample to the farthest: unit direction and length (m)."""
    way = max((position - samples[0][0] for position, _ in samples), key=np.linalg.norm)
    length = np.linalg.norm(way)
    if length == 0:
        sys.exit("the recording does not move")
    return way / length, length


def mean_orientation(samples):
    """Of orientations that stay within half a turn of the first."""
    first = samples[0][1]
    return unit(np.sum([q if q @ first >= 0 else -q for _, q in samples], axis=0))


def scaled_turn(turn, factor):
    """The rotation about the same axis by `factor` times the angle, which is taken in [-pi, pi]."""
    w, *vector = turn if turn[0] >= 0 else -turn
    sine = np.linalg.norm(vector)
    if sine == 0:
        return (1.0, 0.0, 0.0, 0.0)
    half_angle = factor * math.atan2(sine, w)
    return (math.cos(half_angle), *(math.sin(half_angle) * c / sine for c in vector))


def convert(samples, rate, start, direction, scale, turn_factor):
    """Trajectory rows as numbers: t, position, orientation; see the head of this file."""
    way, _ = principal_way(samples)
    aim = shortest_rotation(way, direction)
    base = shortest_rotation((1.0, 0.0, 0.0), direction)
    first_position = samples[0][0]
    from_mean = conjugate(mean_orientation(samples))
    for index, (position, orientation) in enumerate(samples):
        moved = rotate(aim, position - first_position)
        turn = scaled_turn(multiply(orientation, from_mean), turn_factor)
        turn_aimed = multiply(multiply(aim, turn), conjugate(aim))
        yield (index / rate, *(s + scale * m for s, m in zip(start, moved)), *unit(multiply(turn_aimed, base)))


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", help="text file of the recording")
    parser.add_argument("--out", required=True, help="trajectory CSV to write")
    parser.add_argument("--needle", default="needle", help="name of the needle in the scene (default: %(default)s)")
    parser.add_argument("--rate", type=float, default=50.0, help="Hz of the recording's rows (default: %(default)s)")
    parser.add_argument("--start", type=float, nargs=3, default=(0.0, 0.0, 0.0), metavar=("X", "Y", "Z"),
                        help="where the base starts (m, default: origin)")
    parser.add_argument("--direction", type=float, nargs=3, default=(0.0, 0.0, -1.0), metavar=("X", "Y", "Z"),
                        help="where the principal way leads (default: 0 0 -1)")
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--scale", type=float, default=1.0, help="factor on all ways (default: %(default)s)")
    size.add_argument("--travel", type=float, metavar="M", help="scale so that the principal way is this long (m)")
    parser.add_argument("--turn", type=float, default=1.0, help="factor on all turns (default: %(default)s)")
    arguments = parser.parse_args()
    if arguments.rate <= 0 or arguments.scale <= 0 or (arguments.travel is not None and arguments.travel <= 0):
        parser.error("--rate, --scale and --travel must be positive")
    if not any(arguments.direction):
        parser.error("--direction must not be zero")
    return arguments


def main():
    arguments = parse_arguments()
    samples = read_recording(arguments.recording)
    scale = arguments.scale
    if arguments.travel is not None:
        scale = arguments.travel / principal_way(samples)[1]
    rows = convert(samples, arguments.rate, arguments.start, arguments.direction, scale, arguments.turn)
    table = own_files.table_of(COLUMNS, ([f"{time:.9g}", arguments.needle, *(f"{number:.9g}" for number in pose), "0"]
                                         for time, *pose in rows))
    try:
        own_files.write(arguments.out, own_files.sealed(table.decode()), own_files.is_sealed)
    except AcusError as error:
        sys.exit(f"convert_hand_motion.py: {error}")


if __name__ == "__main__":
    main()
