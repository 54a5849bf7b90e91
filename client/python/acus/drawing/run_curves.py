# SPDX-License-Identifier: MIT
"""The forces and events of a run, drawn."""

import numpy as np

from ..errors import RunError

MM = 1e3  # per m
REPETITION = 0.005  # of the run's duration: events of a kind that follow each other faster are drawn once

# Okabe and Ito's colours, which people with any kind of colour vision tell apart.
FORCE_STYLES = {
    "axial resistance": {"color": "black", "linewidth": 2.2},  # wide: its parts are drawn over it
    "contact and cutting, axial": {"color": "#d55e00", "linewidth": 1.0},
    "shaft friction, axial": {"color": "#0072b2", "linewidth": 1.0},
    "lateral (magnitude)": {"color": "#009e73", "linewidth": 1.0},
}
DEPTH_LABELS = {"travel": "depth past the first contact (mm)", "inserted": "needle inside the tissue (mm)"}
EVENT_MARKERS = {"contact": "o", "release": "s", "puncture": "*", "crossing": "P", "reentry": "D", "exit": ">",
                 "withdrawal": "v", "tear": "X", "hub": "h", "slip": "d"}
EVENT_STYLE = {"color": "black", "markerfacecolor": "gold", "markeredgewidth": 0.8, "linestyle": "none"}


def last_epoch(run):
    """Of a run in which the simulation began anew, what came after that: time runs anew, too."""
    return run.of_epoch(run.epochs[-1])


class Curves:
    """What is drawn of one needle, as arrays over the rows of a run; times count from its first row."""

    def __init__(self, run, needle=None):
        track = run[needle or run.needles[0]]
        self.needle = track.needle
        if len(track) < 2:
            raise RunError(f"{run.path}: expected two or more rows of needle '{self.needle}', found {len(track)}; "
                           f"its needles are {', '.join(sorted(run.needles))}")
        self.start = track.time[0]  # s, simulation time
        self.time = track.time - self.start
        self.phase = track.phase
        self.inserted = track.depth
        self.travel = track.travel
        self.touched = track.touched
        self.forces = {
            "axial resistance": track.axial_resistance,
            "contact and cutting, axial": track.along_axis("cutting_force"),
            "shaft friction, axial": track.along_axis("friction_force"),
            "lateral (magnitude)": np.linalg.norm(track.lateral_force, axis=1),
        }

    def row_at(self, time):
        return min(int(np.searchsorted(self.time, time)), len(self.time) - 1)


def depth_of(curves, kind):
    """Depth (m) as `acus-plot --depth` names it."""
    if kind == "inserted":
        return curves.inserted
    touching = np.flatnonzero(curves.phase != "free")
    return curves.travel - (curves.travel[touching[0]] if touching.size else 0.0)


class Event:
    """Something that happened to a needle."""

    def __init__(self, event, start):
        self.time = event.time - start
        self.needle = event.needle
        self.kind = event.kind
        self.position = event.position


def events_to_draw(run, curves):
    """Of all needles, less repetitions."""
    events = [Event(event, curves.start) for event in run.events]
    return without_repetitions(events, REPETITION * (curves.time[-1] - curves.time[0]))


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


def draw_events(axes, curves, events, x, y):
    """Marks the needle's events on the curve y(x), both given over the rows of the run."""
    seen = set()
    for event in events:
        if event.needle != curves.needle:
            continue
        row = curves.row_at(event.time)
        axes.plot(x[row], y[row], EVENT_MARKERS.get(event.kind, "x"), markersize=8, zorder=5,
                  label=once(seen, event.kind), **EVENT_STYLE)


def draw_forces(axes, curves, events):
    """Forces against time."""
    for name, force in curves.forces.items():
        axes.plot(curves.time, force, label=name, **FORCE_STYLES[name])
    draw_events(axes, curves, events, curves.time, curves.forces["axial resistance"])
    axes.set_xlabel("time (s)")
    axes.set_ylabel("force (N)")
    axes.set_xlim(curves.time[0], curves.time[-1])


def draw_depth(axes, curves, depth, label):
    """Depth (m) against time on an axis of its own, on the right. Handles and labels for a legend of both."""
    right = axes.twinx()
    right.plot(curves.time, depth * MM, color="#555555", linestyle="--", linewidth=1.0, label="motion (right axis)")
    right.set_ylabel(label)
    handles, labels = axes.get_legend_handles_labels()
    more_handles, more_labels = right.get_legend_handles_labels()
    return handles + more_handles, labels + more_labels


def draw_grid(axes):
    axes.axhline(0, color="black", linewidth=0.6)
    axes.grid(True, color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
