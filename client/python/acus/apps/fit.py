# SPDX-License-Identifier: MIT
"""Finds the parameters of a scene with which it gives a measured curve.

  acus-fit insertion_pullback force.csv --speed 0.05 \\
      --free 'tissue.regions[phantom].material.young_modulus=3e3:30e3' \\
      --free 'tissue.regions[phantom].interaction.puncture_force=0.2:2'
  acus-fit liver.yaml hold.csv --motion motion.csv --free 'tissue.regions[liver].interaction.pressure=5e3:50e3' \\
      --free data.shift=0:0.5 --until 8

The file has a header with units: time_s or travel_mm (of the base), and force_N (axial resistance) or deflection_mm (of the
tip); s, ms, m, mm, um, N, mN. The first line that is printed says how it was read. --until and data.shift are in s or m. The
needle goes in along its axis at --speed, as far as the data go, or moves as --motion says; its motion begins where the data
have 0, or at data.shift if that is free.

Writes fit.json (values, 95 % intervals, correlations, and which parameters the data cannot identify, and why), scene.yaml
(the scene with the values), curves.csv and fit.png. docs/fitting.md explains how it is done.

Exit status: 0; 1 bad arguments, data or scene; 2 a parameter cannot be identified; 130 interrupted.
"""

import argparse
import dataclasses
import math
import os
import sys

from acus.apps.arguments import BAD_ARGUMENTS, Arguments, whole_number
from acus.errors import AcusError, FitError
from acus.fit import Fit, read_measurement
from acus.fit.fitted import make_folder
from acus.study import Insertion
from acus.study.pictures import figure

UNIDENTIFIED, INTERRUPTED = 2, 130


def range_of(text):
    """(name, (low, high)) of NAME=LOW:HIGH."""
    name, equals, bounds = text.rpartition("=")
    low, colon, high = bounds.partition(":")
    try:
        if not (name and equals and colon):
            raise ValueError
        return name, (float(low), float(high))
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected NAME=LOW:HIGH, such as data.shift=0:0.5, found '{text}'") from None


def positive(text):
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"expected a number above 0, found '{text}'")
    return value


def seed(text):
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number, found '{text}'")
    return int(text)


def parse_arguments():
    parser = Arguments(prog="acus-fit", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help="a file, or the name of a project scene")
    parser.add_argument("data", help="CSV")
    parser.add_argument("--free", type=range_of, action="append", required=True, metavar="NAME=LOW:HIGH",
                        help="a parameter and its range: a field of the scene, motion.speed and such, or data.shift (s or m, where "
                             "the data have the beginning of the motion); may be given again. A range whose high is at least 3 times "
                             "its low goes by the logarithm")
    motion = parser.add_mutually_exclusive_group(required=True)
    motion.add_argument("--speed", type=positive, metavar="M/S", help="the needle goes in along its axis")
    motion.add_argument("--motion", metavar="FILE", help="a trajectory, as for acus-replay")
    parser.add_argument("--depth", type=positive, metavar="M", help="with --speed: way of the base (default: as far as the data go)")
    parser.add_argument("--hold", type=positive, metavar="S", help="with --speed: rest at its end (default: none)")
    parser.add_argument("--until", type=float, default=math.inf, metavar="X",
                        help="fit only what is before it (s or m); the rest is predicted, and compared")
    parser.add_argument("--columns", type=lambda text: text.split(","), metavar="NAMES",
                        help="the two that count, such as time_s,force_N, where there are more; all of a file without a header")
    parser.add_argument("--folder", metavar="DIR", help="for results (default: fits/DATA, by the name of the data)")
    parser.add_argument("--workers", type=lambda text: whole_number(text, most=10_000), help="runs at once (default: one for each processor)")
    parser.add_argument("--seed", type=seed, default=0, help="of the cases that it begins with (default: 0)")
    parser.add_argument("--quiet", action="store_true", help="no progress on stderr")
    arguments = parser.parse_args()
    if arguments.motion and (arguments.depth or arguments.hold):
        parser.error("--depth and --hold: are for --speed")
    if len({name for name, _ in arguments.free}) < len(arguments.free):
        parser.error("--free: a name is there twice")
    return arguments


def measured(arguments):
    """The Measurement with its motion."""
    motion = arguments.motion or Insertion(arguments.depth or 1.0, arguments.speed, hold=arguments.hold or 0.0)
    data = read_measurement(arguments.data, motion, columns=arguments.columns, until=arguments.until)
    if arguments.motion or arguments.depth:
        return data
    if data.x[-1] <= 0:
        raise FitError(f"{arguments.data}: no value of {data.over} is above 0; give --depth")
    end = float(data.x[-1]) if data.over == "travel" else (float(data.x[-1]) - motion.hold) * arguments.speed
    if end <= 0:
        raise FitError(f"{arguments.data}: it ends before --hold does; give --depth")
    return dataclasses.replace(data, motion=dataclasses.replace(motion, depth=end))


def main():
    arguments = parse_arguments()
    try:
        data = measured(arguments)
        folder = arguments.folder or os.path.join("fits", os.path.splitext(data.name)[0])
        fit = Fit(arguments.scene, data, dict(arguments.free))
        make_folder(folder)
        figure(1, 1, 1, 1)  # which tells if there is no matplotlib, before all runs
        print(data.told, flush=True)
        done = fit.run(seed=arguments.seed, workers=arguments.workers, progress=not arguments.quiet)
        print(done)
        done.write(folder)
        print(f"written into {folder}: fit.json, scene.yaml, curves.csv, fit.png")
        return UNIDENTIFIED if done.doubts else 0
    except AcusError as error:
        print(f"acus-fit: {error}", file=sys.stderr)
        return BAD_ARGUMENTS
    except KeyboardInterrupt:
        print("\nacus-fit: interrupted", file=sys.stderr)
        return INTERRUPTED
