# SPDX-License-Identifier: MIT
"""Draws how punctual a run in real time was, from the two files that acus-replay --timing NAME.csv writes.

Above: how long poses took to be felt, as a histogram with the share of slower ones beside it. Below: for each second of
the run, how long after they were due the server's ticks began and ended; ticks that end beyond the period are late.
"""

import os

import matplotlib.pyplot as plt
import numpy as np

from acus.drawing import run_curves
from acus.timing import Timing

MS = 1e3  # per s
BINS = 120
GOAL = 0.2e-3  # s beyond one tick, of a round trip

PERCENTILES = (("p50", "-", 1.4), ("p99", "--", 1.0), ("max", ":", 1.0))
SERIES = (("end", "ended", "#0072b2"), ("wake", "began", "#e69f00"))


def draw_round_trips(axes, seconds, period):
    shown = np.minimum(seconds, np.quantile(seconds, 0.999) * 1.05)
    axes.hist(shown * MS, bins=BINS, color="#0072b2")
    axes.set_yscale("log")
    axes.set_xlabel("from a pose to the first force that used it (ms); the slowest of 1,000 at the right edge")
    axes.set_ylabel("poses")
    for q, style in ((0.5, "-"), (0.99, "--")):
        value = np.quantile(seconds, q) * MS
        axes.axvline(value, color="black", linestyle=style, label=f"p{100 * q:.0f} {value:.3f} ms")
    axes.plot([], [], " ", label=f"max {seconds.max() * MS:.3f} ms of {len(seconds)}")
    if period > 0:
        axes.axvline((period + GOAL) * MS, color="#d55e00", label=f"one tick and {GOAL * MS:.1f} ms")
    axes.legend(frameon=False)


def draw_punctuality(axes, stats, period):
    time = stats["received_s"]
    for name, what, colour in SERIES:
        for quantile, style, width in PERCENTILES:
            axes.plot(time, stats[f"{name}_{quantile}_s"] * MS, style, color=colour, linewidth=width,
                      label=f"{what}, {quantile}")
    late = stats["late"]
    if period > 0:
        axes.axhline(period * MS, color="#d55e00", label=f"period; {late.sum():.0f} late of "
                                                         f"{stats['ticks'].sum():.0f}")
    axes.set_yscale("log")
    axes.set_xlabel("time (s)")
    axes.set_ylabel("after a tick was due (ms)")
    axes.legend(frameon=False, ncols=3)


def draw(path, title):
    """The figure; raises RunError."""
    timing = Timing(path)
    period = float(np.max(timing.stats["time_step_s"]))
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(11, 9.5), constrained_layout=True)
    figure.suptitle(title or os.path.basename(path), fontsize=13)
    draw_round_trips(upper, timing.trips["round_trip_s"], period)
    draw_punctuality(lower, timing.stats, period)
    for axes in (upper, lower):
        run_curves.draw_grid(axes)
    return figure
