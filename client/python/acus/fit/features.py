# SPDX-License-Identifier: MIT
"""What a curve of force looks like, in a few numbers. Two curves whose punctures are a little apart differ by newtons
there, and a small change of a parameter makes that no better; their features differ by that little. A fit begins with them."""

import math

import numpy as np

PROMINENCE = 0.15  # of a peak, as a share of the curve's range
CLOSE = 0.08  # of the range of x: the drop after a puncture
SHARES = (0.05, 0.25, 0.5, 1.0)  # of what comes after the highest point


def features(x, y):
    """{name: (value, size)}: forces (as y) of the size of the curve's range, places (as x) of a tenth of the range of x.

    first_peak, at_first_peak   the first peak that stands out, as of a puncture: height and place
    half_rise                   where the curve first reaches half of that, or of its highest point if no peak stands out
    after_peak                  the lowest value right behind it
    highest, at_highest
    later_K                     values after the highest point, at shares of what follows
    """
    size, width = max(float(np.ptp(y)), 1e-300), 0.1 * max(float(np.ptp(x)), 1e-300)
    found = {}
    peak = first_peak(y, PROMINENCE * size)
    if peak is not None:
        behind = (x >= x[peak]) & (x <= x[peak] + CLOSE * np.ptp(x))
        found["first_peak"] = (y[peak], size)
        found["at_first_peak"] = (x[peak], width)
        found["after_peak"] = (float(np.min(y[behind])), size)
    highest = int(np.argmax(y))
    top = highest if peak is None else peak
    half = np.flatnonzero(y[:top + 1] >= y[0] + 0.5 * (y[top] - y[0]))
    found["half_rise"] = (x[half[0]], width)
    found["highest"] = (y[highest], size)
    found["at_highest"] = (x[highest], 3 * width)
    for number, share in enumerate(SHARES):
        found[f"later_{number}"] = (float(np.interp(x[top] + share * (x[-1] - x[top]), x, y)), size)
    return found


def first_peak(y, least):
    """Its index: of the highest value before the curve first falls by `least` from it, after it rose by as much."""
    low, high = y[0], 0
    for i, value in enumerate(y):
        if value > y[high]:
            high = i
        if y[high] - value >= least and y[high] - low >= least:
            return high
        if value < low:
            low, high = value, i
    return None


def misfit(measured, simulated):
    """Differences of the features that the measured curve has, each as a share of its size and never above 1, which stands
    for a feature that the simulated curve has not."""
    apart = [(simulated[name][0] - value) / size if name in simulated else math.inf for name, (value, size) in measured.items()]
    return np.array([each / math.hypot(1, each) if math.isfinite(each) else 1.0 for each in apart])
