# SPDX-License-Identifier: MIT
"""Where a needle may go in, for a coarse search: geometry alone, before anything is simulated."""

import math

import numpy as np

from ..errors import PlanError
from .candidates import ON_SURFACE

PLACES = (4_000, 40_000, 400_000)  # of the surface: more where few of them serve
ENOUGH, LOOKED_AT = 50, 400  # of these
STEEPEST = 0.3  # cosine of the angle between the surface's normal and the way
APART = 1e-3  # m
WIDE = (4e-3, 2e-3, 1e-3, 0.0)  # m that a way keeps from walls: the widest of which there are enough


def entries_of(problem, count, seed):
    """Points of the surface, as far from each other as so many can be; where straight ways to the target are free of walls,
    of these alone, the wider ones first. Raises PlanError."""
    if not problem.tilt:
        found = problem.surface.hit(problem.target, problem.axis)
        if found is None:
            raise PlanError("tilt: in the scene's direction the needle does not meet the tissue on its way to the target; give more than 0")
        return [found[0]]
    for places in PLACES:
        able, inside = able_of(problem, places, seed)
        free = np.array([problem.corridor(each) for each in able])
        if np.sum(free > 0) >= ENOUGH or (problem.entry_region and problem.entry_region.region is not None):
            break  # a region's surface is large, and takes time to look at
    if not inside:
        raise PlanError("entry_region: no part of the tissue's surface lies in it; " + problem.extent)
    if not len(able):
        raise PlanError(f"entry_region: from nowhere in it the needle, which can go in {problem.longest:g} m, reaches the target within "
                        f"tilt={problem.tilt:.3g} rad of the scene's direction; give a larger tilt, another region or a longer needle")
    return farthest(widest(able, free, count), count)


def able_of(problem, places, seed):
    """(points from which the target can be reached, whether the entry region has any surface)"""
    points, triangles = problem.surface.points(places, seed)
    ways = problem.target - points
    lengths = np.linalg.norm(ways, axis=1)
    able = np.sum(ways * problem.surface.normals[triangles], axis=1) < -STEEPEST * lengths
    able &= (lengths < problem.longest) & (ways @ problem.axis > math.cos(problem.tilt) * lengths)
    inside = np.ones(places, dtype=bool)
    if problem.entry_region is not None:
        inside = problem.entry_region.distances(problem.model, points) <= ON_SURFACE
    found = np.flatnonzero(able & inside)[:LOOKED_AT]
    return points[[each for each in found if problem.is_even(points[each], ways[each] / lengths[each])]].reshape(-1, 3), inside.any()


def widest(points, free, count):
    """Those whose ways keep farthest from walls, so many at least if so many keep from them at all; all where none does."""
    for least in WIDE:
        wide = points[free > least]
        if len(wide) >= count:
            return wide
    return wide if len(wide) else points


def farthest(points, count):
    """So many of the points: each is as far as can be from those before it, the first from their middle the nearest."""
    chosen = [int(np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1)))]
    distances = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < count and distances.max() > APART:
        chosen.append(int(np.argmax(distances)))
        distances = np.minimum(distances, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return [points[each] for each in chosen]
