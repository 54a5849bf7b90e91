# SPDX-License-Identifier: MIT
"""Draws the forces of a run that acus-replay wrote, against depth and against time.

    acus-plot run.csv               # run.png, of acus-replay --out run.csv
    acus-plot timing.csv            # timing.png: how punctual the run was, of acus-replay --timing timing.csv
    acus-plot run.csv --jumps       # draws nothing: lists the worst jumps of the base force with their causes

Axial resistance is what the holder feels along the needle: -base_force . axis, positive when the tissue resists going
in. Its parts, and the lateral force, come from the same file. Depth is how far the base went past the place where the
tip first touched the tissue (--depth travel), or the length of needle inside it (--depth inserted). Events are read
from NAME.events.csv beside NAME.csv if it exists.

Of a timing file: above, how long poses took to be felt, as a histogram with the share of slower ones beside it; below, for
each second of the run, how long after they were due the server's ticks began and ended. Ticks that end beyond the period
are late.

A jump is what a hand feels as a click: the change of the base force (in the base's frame) from one tick to the next, less
that of the ticks around it; a force that rises steadily, however fast, or that begins to rise, does not jump. Its cause is
a contact, a puncture, a crossing in that tick or the five before it; where there is none the flags of the tick are named.
With --above F the exit status is 1 if a jump of more than F newtons has no event as its cause.
"""

import argparse
import os
import re
import sys

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import acus  # noqa: E402
from acus.apps import jumps, timing_plot  # noqa: E402
from acus.drawing import figures, run_curves  # noqa: E402

SHORTEST_PART = 0.1  # s, of a part of the motion; shorter ones belong to their neighbours
RESTING = 0.05  # of the largest speed: slower counts as hold

PART_COLOURS = {
    "approach": "#8c8c8c",
    "insertion": "#0072b2",
    "hold": "#cc79a7",
    "pullback": "#e69f00",
    "re-insertion": "#009e73",
    "withdrawal": "#d55e00",
}


def direction_of_motion(curves):
    """+1 going in, -1 coming out, 0 resting, per row; parts shorter than SHORTEST_PART take their neighbour's value."""
    speed = np.gradient(curves.travel, curves.time)
    limit = RESTING * np.max(np.abs(speed))
    direction = np.where(speed > limit, 1, np.where(speed < -limit, -1, 0))
    for begin, end in runs_of_equal(direction):
        if begin > 0 and curves.time[end - 1] - curves.time[begin] < SHORTEST_PART:
            direction[begin:end] = direction[begin - 1]
    return direction


def runs_of_equal(values):
    """[begin, end) of each stretch of equal values."""
    edges = np.flatnonzero(values[1:] != values[:-1]) + 1
    return list(zip(np.concatenate([[0], edges]), np.concatenate([edges, [len(values)]])))


def parts_of(curves):
    """[(begin, end, name)]: the motion cut into the parts that PART_COLOURS names."""
    direction = direction_of_motion(curves)
    touched = curves.touched
    kinds = np.where(touched, direction, 2)
    pulled = False
    parts = []
    for begin, end in runs_of_equal(kinds):
        kind = kinds[begin]
        last_way_out = kind == -1 and not np.any(direction[end:] == 1) and curves.inserted[-1] == 0
        pulled = pulled or kind == -1
        names = {2: "approach", 1: "re-insertion" if pulled else "insertion", 0: "hold", -1: "pullback"}
        parts.append((begin, end, "withdrawal" if last_way_out else names[kind]))
    return parts


def draw_against_depth(axes, curves, depth, label, parts, events):
    force = curves.forces["axial resistance"]
    seen = set()
    for begin, end, name in parts:
        stretch = slice(begin, end + 1)  # one row on, so that neighbouring parts join
        axes.plot(depth[stretch] * run_curves.MM, force[stretch], color=PART_COLOURS[name], linewidth=1.3,
                  label=run_curves.once(seen, name))
    run_curves.draw_events(axes, curves, events, depth * run_curves.MM, force)
    axes.set_xlabel(label)
    axes.set_ylabel("axial resistance (N)")


def draw_against_time(axes, curves, depth, label, parts, events):
    for begin, end, name in parts:
        last = min(end, len(curves.time) - 1)
        axes.axvspan(curves.time[begin], curves.time[last], color=PART_COLOURS[name], alpha=0.10, linewidth=0)
    run_curves.draw_forces(axes, curves, events)
    return run_curves.draw_depth(axes, curves, depth, label)


def draw(curves, depth_kind, events, title):
    depth = run_curves.depth_of(curves, depth_kind)
    label = run_curves.DEPTH_LABELS[depth_kind]
    parts = parts_of(curves)
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(11, 9.5), constrained_layout=True)
    figure.suptitle(title, fontsize=13)
    draw_against_depth(upper, curves, depth, label, parts, events)
    upper.legend(loc="center left", bbox_to_anchor=(1.07, 0.5), frameon=False)
    handles = draw_against_time(lower, curves, depth, label, parts, events)
    lower.legend(*handles, loc="center left", bbox_to_anchor=(1.07, 0.5), frameon=False)
    run_curves.draw_grid(upper)
    run_curves.draw_grid(lower)
    return figure


def draw_run(arguments):
    with acus.Run(arguments.run) as whole:
        run = run_curves.last_epoch(whole)
        curves = run_curves.Curves(run, arguments.needle)
        events = run_curves.events_to_draw(run, curves)
    title = arguments.title or f"Force on needle '{curves.needle}' ({os.path.basename(arguments.run)})"
    return draw(curves, arguments.depth, events, title)


def list_jumps(arguments):
    """The exit status."""
    jumped = jumps.jumps_of(acus.Run(arguments.run), arguments.needle)
    print("\n".join(jumps.table(jumped, arguments.jumps)))
    if arguments.above is None:
        return 0
    found = jumps.unexplained(jumped, arguments.above)
    print(f"{found} above {arguments.above:g} N without an event but contact or release")
    return 1 if found else 0


def is_timing(path):
    """Whether acus-replay --timing wrote the file."""
    try:
        with open(path, encoding="utf-8-sig", errors="replace") as file:
            return "round_trip_s" in re.split("[,;\t]", file.readline().strip())
    except OSError:
        return False  # who reads it says why


def count(text):
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"expected a number of jumps, at least 1, found '{text}'")
    return int(text)


def parse_arguments():
    parser = argparse.ArgumentParser(prog="acus-plot", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", help="CSV written by acus-replay --out or --timing")
    parser.add_argument("--out", help="picture to write, .png, .svg or .pdf (default: the run's name with .png)")
    parser.add_argument("--needle", help="which needle to draw (default: the one of the first row); whose jumps to list "
                                         "(default: all)")
    parser.add_argument("--depth", choices=("travel", "inserted"), default="travel", help="default: %(default)s")
    parser.add_argument("--title", help="default: names the needle and the file")
    parser.add_argument("--jumps", type=count, nargs="?", const=10, metavar="N", help="list the N worst (default: 10)")
    parser.add_argument("--above", type=float, metavar="F",
                        help="with --jumps: status 1 if one above F newtons has no event as its cause, contact and "
                             "release aside")
    arguments = parser.parse_args()
    if arguments.above is not None and arguments.jumps is None:
        parser.error("--above goes with --jumps")
    return arguments


def main():
    arguments = parse_arguments()
    try:
        if arguments.jumps is not None:
            return list_jumps(arguments)
        timing = is_timing(arguments.run)
        figure = timing_plot.draw(arguments.run, arguments.title) if timing else draw_run(arguments)
        figures.save(figure, arguments.out or os.path.splitext(arguments.run)[0] + ".png")
        return 0
    except acus.AcusError as error:
        sys.exit(str(error))
