# SPDX-License-Identifier: MIT
"""Runs as acus-replay writes them (NAME.csv and NAME.events.csv), and how their forces and events are drawn.

What plot and picture have in common. SI units; times count from the first row of the run.
"""

import csv
import os
import sys

import numpy as np
from PIL import Image

MM = 1e3  # per m
DOTS_PER_INCH = 130  # of pixel pictures
COLOURS = 256  # of a .png: nobody sees a difference, and the file is a quarter as large
REPETITION = 0.005  # of the run's duration: events of a kind that follow each other faster are drawn once

# Okabe and Ito's colours, which people with any kind of colour vision tell apart.
FORCE_STYLES = {
    "axial resistance": {"color": "black", "linewidth": 2.2},  # wide: its parts are drawn over it
    "contact and cutting, axial": {"color": "#d55e00", "linewidth": 1.0},
    "shaft friction, axial": {"color": "#0072b2", "linewidth": 1.0},
    "lateral (magnitude)": {"color": "#009e73", "linewidth": 1.0},
}
EVENT_MARKERS = {"contact": "o", "release": "s", "puncture": "*", "crossing": "P", "reentry": "D", "exit": ">",
                 "withdrawal": "v"}
EVENT_STYLE = {"color": "black", "markerfacecolor": "gold", "markeredgewidth": 0.8, "linestyle": "none"}


class Run:
    """The columns of one needle that are drawn, as arrays over the rows."""

    def __init__(self, path, needle=None):
        rows = read_rows(path)
        self.needle = needle or rows[0]["needle"]
        names = sorted({row["needle"] for row in rows})
        rows = [row for row in rows if row["needle"] == self.needle]
        if len(rows) < 2:
            sys.exit(f"{path}: expected two or more rows of needle '{self.needle}', found {len(rows)}; "
                     f"its needles are {', '.join(names)}")
        self.start = float(rows[0]["time_s"])  # s, simulation time
        self.time = column(rows, "time_s") - self.start
        self.phase = np.array([row["phase"] for row in rows])
        self.inserted = column(rows, "depth_m")
        axis = axis_of(np.stack([column(rows, f"base_orientation_{c}") for c in "wxyz"], axis=1))
        position = vector(rows, "base_position", "m")
        self.travel = np.sum((position - position[0]) * axis[0], axis=1)
        lateral = vector(rows, "lateral_force", "N")
        self.forces = {
            "axial resistance": -np.sum(vector(rows, "base_force", "N") * axis, axis=1),
            "contact and cutting, axial": -np.sum(vector(rows, "cutting_force", "N") * axis, axis=1),
            "shaft friction, axial": -np.sum(vector(rows, "friction_force", "N") * axis, axis=1),
            "lateral (magnitude)": np.linalg.norm(lateral, axis=1),
        }

    def row_at(self, time):
        return min(int(np.searchsorted(self.time, time)), len(self.time) - 1)

    def touched(self):
        """Whether the tip has touched the tissue by each row."""
        return np.logical_or.accumulate(self.phase != "free")


class Event:
    """Something that happened to a needle."""

    def __init__(self, row, start):
        self.time = float(row["time_s"]) - start
        self.needle = row["needle"]
        self.kind = row["kind"]
        self.position = np.array([float(row.get(f"position_{c}_m") or "nan") for c in "xyz"])


def read_rows(path):
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    except OSError as error:
        sys.exit(f"{path}: {error.strerror}")
    except ValueError:
        rows = []
    if not rows or "needle" not in rows[0]:
        sys.exit(f"{path}: expected a run written by acus-replay, found no rows or no column 'needle'")
    return rows


def column(rows, name):
    try:
        return np.array([float(row[name]) for row in rows])
    except KeyError:
        sys.exit(f"the run has no column '{name}'")


def vector(rows, name, unit):
    return np.stack([column(rows, f"{name}_{c}_{unit}") for c in "xyz"], axis=1)


def axis_of(quaternions):
    """Where each orientation (w, x, y, z) turns +x, the direction from base to tip."""
    w, x, y, z = np.asarray(quaternions).T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=-1)


def read_events(run_path, run):
    """The events of all needles that stand beside a run, less repetitions; none if there is no such file."""
    events = [Event(row, run.start) for row in read_event_rows(run_path)]
    return without_repetitions(events, REPETITION * (run.time[-1] - run.time[0]))


def read_event_rows(run_path):
    """All events that stand beside a run, as they were written; none if there is no such file."""
    path = os.path.splitext(run_path)[0] + ".events.csv"
    if not os.path.exists(path):
        return []
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def without_repetitions(events, gap):
    """Without those that come within `gap` seconds after the last of their kind and needle."""
    kept, last = [], {}
    for event in events:
        series = (event.needle, event.kind)
        if event.time - last.get(series, -np.inf) > gap:
            kept.append(event)
        last[series] = event.time
    return kept


def once(seen, label):
    """The label the first time, so that the legend holds it once; None afterwards."""
    if label in seen:
        return None
    seen.add(label)
    return label


def draw_events(axes, run, events, x, y):
    """Marks the needle's events on the curve y(x), both given over the rows of the run."""
    seen = set()
    for event in events:
        if event.needle != run.needle:
            continue
        row = run.row_at(event.time)
        axes.plot(x[row], y[row], EVENT_MARKERS.get(event.kind, "x"), markersize=8, zorder=5,
                  label=once(seen, event.kind), **EVENT_STYLE)


def draw_forces(axes, run, events):
    """Forces against time."""
    for name, force in run.forces.items():
        axes.plot(run.time, force, label=name, **FORCE_STYLES[name])
    draw_events(axes, run, events, run.time, run.forces["axial resistance"])
    axes.set_xlabel("time (s)")
    axes.set_ylabel("force (N)")
    axes.set_xlim(run.time[0], run.time[-1])


def draw_depth(axes, run, depth, label):
    """Depth (m) against time on an axis of its own, on the right. Handles and labels for a legend of both."""
    right = axes.twinx()
    right.plot(run.time, depth * MM, color="#555555", linestyle="--", linewidth=1.0, label="motion (right axis)")
    right.set_ylabel(label)
    handles, labels = axes.get_legend_handles_labels()
    more_handles, more_labels = right.get_legend_handles_labels()
    return handles + more_handles, labels + more_labels


def draw_grid(axes):
    axes.axhline(0, color="black", linewidth=0.6)
    axes.grid(True, color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)


def save(figure, path):
    try:
        figure.savefig(path, dpi=DOTS_PER_INCH)
        if path.lower().endswith(".png"):
            with Image.open(path) as image:
                small = image.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE, 1, dither=Image.Dither.NONE)
            small.save(path, optimize=True)
    except (OSError, ValueError) as error:
        sys.exit(f"{path}: {error}")
