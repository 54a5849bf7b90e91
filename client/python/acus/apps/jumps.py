# SPDX-License-Identifier: MIT
"""Lists the worst jumps of the base force in a run that acus-replay wrote, with the time and the cause of each.

A jump is what a hand feels as a click: the change of the base force (in the base's frame) from one tick to the next, less
that of the ticks around it. Of the three ticks before and the three after, those count that explain more of it: a force
that rises steadily, however fast, or that begins to rise, does not jump.

The cause is what happened to the needle in that tick or the five before it, read from NAME.events.csv beside NAME.csv: a
contact, a puncture, a crossing. Where there is no such event the flags of the tick are named, or nothing. A contact or a
release is where a force begins or ends, and explains no jump.
"""

import numpy as np

AROUND = 3  # ticks on either side
EARLIER = 5  # ticks before a jump in which its cause may lie
SMOOTH = {"contact", "release"}  # events at which no force jumps


def sizes(forces):
    """What the change from each row to the next has beyond the changes around it (N); the first row has none."""
    change = np.diff(forces, axis=0)
    jumps = np.zeros(len(forces))
    for i in range(len(change)):
        around = [change[max(0, i - AROUND):i], change[i + 1:i + 1 + AROUND]]
        means = [part.mean(axis=0) for part in around if len(part)]
        jumps[i + 1] = min((np.linalg.norm(change[i] - mean) for mean in means), default=0.0)
    return jumps


class Jump:
    """One of a needle: the row of its track at whose tick the force is another one, and what happened there."""

    def __init__(self, size, track, row, kinds):
        self.size = size
        self.track = track
        self.row = row
        self.events = kinds
        flags = track.flags[row]
        self.cause = ", ".join(kinds) or (f"flags {flags}" if flags else "none")

    def line(self):
        track, row = self.track, self.row
        before, force = track.base_force_in_base[row - 1], track.base_force_in_base[row]
        return (f"{track.time[row]:10.4f}  {track.needle:12}  {self.size:8.4f}  {as_text(before)}  {as_text(force)}  "
                f"{track.phase[row]:7}  {1e3 * track.depth[row]:8.1f}  {self.cause}")


HEADER = (f"{'time (s)':>10}  {'needle':12}  {'jump (N)':>8}  {'from (N, in base)':23}  {'to':23}  {'phase':7}  "
          f"{'depth/mm':>8}  cause")


def as_text(force):
    return "{:7.3f} {:7.3f} {:7.3f}".format(*force)


def jumps_of_needle(track, events):
    """Of a needle's track and its events, as (tick, kind). Rows with a lost tick before them have no jump."""
    found = []
    for begin, end in stretches(track.tick):
        for i, size in enumerate(sizes(track.base_force_in_base[begin:end])[1:], begin + 1):
            kinds = [kind for tick, kind in events if track.tick[i] - EARLIER <= tick <= track.tick[i]]
            found.append(Jump(size, track, i, kinds))
    return found


def stretches(ticks):
    """[begin, end) of each stretch of ticks that follow each other."""
    gaps = np.flatnonzero(np.diff(ticks) != 1) + 1
    return list(zip([0, *gaps], [*gaps, len(ticks)]))


def jumps_of(run, needle):
    """Of a needle, or of all; the worst first."""
    found = []
    for name in [needle] if needle else run.needles:
        own = [(event.tick, event.kind) for event in run.events if event.needle == name]
        found += jumps_of_needle(run[name], own)
    return sorted(found, key=lambda jump: -jump.size)


def table(found, worst):
    """Lines for people of the so many worst of jumps_of()."""
    return [HEADER, *(jump.line() for jump in found[:worst])]


def unexplained(found, limit):
    """How many of jumps_of() above a limit (N) have no event as their cause, contacts and releases aside."""
    return sum(jump.size > limit and SMOOTH.issuperset(jump.events) for jump in found)
