# SPDX-License-Identifier: MIT
"""Simulated curves, and how far measured ones are from them.

A point's misfit is its distance from the other curve, across it, in a plane in which a tenth of the range of x is as long as
the range of y: where the curve is flat it is the difference of y, where it falls at a puncture that of x. The differences
of y alone are as large as the force where two punctures are apart by a hair, and tell nothing of how far. Both curves are
looked at from the other: a peak that is too high has no measured point near it, but points of its own.
"""

import math

import numpy as np

WIDTH = 0.1  # of the range of x, as long as the range of y
POINTS = 2000  # along a curve
LOOKS = 400  # from a simulated curve at the measured one


class Curve:
    """x, y: points of a polyline, as they follow each other in time."""

    def __init__(self, x, y):
        self.x, self.y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)

    def at(self, x):
        """y there; at the ends as the first and the last. x has to rise."""
        return np.interp(x, self.x, self.y)

    def shifted(self, by):
        return Curve(self.x + by, self.y)

    def over(self, first, last):
        """Its points between two x; where it does not reach so far, level."""
        within = (self.x > first) & (self.x < last)
        ends = self.at(np.array([first, last]))
        return np.column_stack([[first, *self.x[within], last], [ends[0], *self.y[within], ends[1]]])

    def misfit(self, measurement, points):
        """Signed distances of those points of a measurement from the curve, as shares of its size: above the curve positive,
        and before it where it rises."""
        scale, x = scale_of(measurement), measurement.x
        line = self.over(min(x[0], self.x[0]), max(x[-1], self.x[-1]))
        return distances(evenly(line / scale, POINTS), data_of(measurement, points) / scale)

    def excess(self, measurement, points):
        """The same the other way: of points evenly along the curve, as far as those of the measurement go, from its line."""
        scale, x = scale_of(measurement), measurement.x[points]
        own = evenly(self.over(x[0], x[-1]) / scale, LOOKS)
        return distances(evenly(data_of(measurement, points) / scale, POINTS), own)


def scale_of(measurement):
    return np.array([WIDTH * float(np.ptp(measurement.x)), measurement.size])


def data_of(measurement, points):
    return np.column_stack([measurement.x, measurement.y])[points]


def distances(line, data):
    from scipy.spatial import cKDTree  # pylint: disable=import-outside-toplevel  # takes a second
    _, nearest = cKDTree(line).query(data)
    return signed_distances(line, data, nearest)


def evenly(line, count):
    """Points of a polyline at equal lengths along it, so that it has some where it is steep."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    places = np.linspace(0, length[-1], count)
    return np.column_stack([np.interp(places, length, line[:, k]) for k in range(2)])


def signed_distances(line, data, nearest):
    """From the nearer one of both segments at the nearest point."""
    best = np.full(len(data), math.inf)
    for first in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(line) - 2)):
        start, way = line[first], line[first + 1] - line[first]
        length2 = np.maximum(np.sum(way**2, axis=1), 1e-300)
        share = np.clip(np.sum((data - start) * way, axis=1) / length2, 0, 1)
        apart = data - start - share[:, None] * way
        side = np.where(way[:, 0] * apart[:, 1] - way[:, 1] * apart[:, 0] >= 0, 1.0, -1.0)
        distance = side * np.linalg.norm(apart, axis=1)
        best = np.where(np.abs(distance) < np.abs(best), distance, best)
    return best
