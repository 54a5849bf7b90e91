# SPDX-License-Identifier: MIT
"""Places as a planner is given them: shapes as scenes have them, {"sphere": {"center": [0, 0, 0], "radius": 0.004}}, or names
of regions of the tissue; distances of points to their surface, negative inside. All in m, in the world, at rest."""

import dataclasses
import functools
import math

import numpy as np

from ..errors import PlanError
from ..study.values import check_vector
from .checks import check_positive, named
from .tissue import Tetrahedra, boundary_of, distances_to_triangles, extent_of, tetrahedra_of

FIELDS = {"sphere": {"center", "radius"}, "box": {"min", "max"}, "half_space": {"point", "normal"},
          "cylinder": {"from", "to", "radius"}}
NEEDED = {"sphere": {"center", "radius"}, "box": set(), "half_space": {"point"}, "cylinder": {"from", "to", "radius"}}


@dataclasses.dataclass(frozen=True)
class Place:
    """A shape, or a region by its name. `field` names it in errors."""

    field: str
    given: object

    def __post_init__(self):
        if not isinstance(self.given, str):
            parts_of(self.field, self.given)

    @property
    def region(self):
        return self.given if isinstance(self.given, str) else None

    def check(self, model):
        if self.region is not None and self.region not in model.regions:
            raise PlanError(f"{self.field}: the tissue has no region '{self.region}'; it has {', '.join(model.regions)}")
        corners = model.rest_positions[model.tetrahedra]
        longest = np.linalg.norm(corners[:, 1:] - corners[:, :1], axis=2).max()
        if self.region is None and self.distances(model, model.rest_positions).min() > longest:
            raise PlanError(f"{self.field}: it lies nowhere near the tissue; {extent_of(model)}, and so are shapes")

    def near(self, model, points, within):
        """Those of the points (n, 3) that may lie so near, or inside: of a shape all."""
        if self.region is None:
            return points
        nodes = model.rest_positions[tetrahedra_of(model, self.region)].reshape(-1, 3)
        return points[np.all((points > nodes.min(axis=0) - within) & (points < nodes.max(axis=0) + within), axis=1)]

    def distances(self, model, points):
        """Of points (n, 3) to the surface, negative inside; of an intersection of shapes a lower bound outside."""
        points = np.asarray(points, dtype=float).reshape(-1, 3)
        if self.region is None:
            return np.max([part(points) for part in parts_of(self.field, self.given)], axis=0)
        within, triangles = region_of(model, self.region)
        inside = np.array([within.find(point) is not None for point in points], dtype=bool)
        return np.where(inside, -1, 1) * distances_to_triangles(points, triangles)


@functools.lru_cache(16)
def region_of(model, name):
    """Of a region at rest: its Tetrahedra, its boundary's triangles (n, 3, 3)."""
    tetrahedra = tetrahedra_of(model, name)
    return Tetrahedra(model.rest_positions[tetrahedra]), model.rest_positions[boundary_of(tetrahedra)]


def parts_of(field, given):
    """Distance functions, whose largest counts."""
    if not isinstance(given, dict) or not given:
        raise PlanError(f"{field}: expected the name of a region, or a shape as scenes have it, such as "
                        f"{{'sphere': {{'center': [0, 0, 0], 'radius': 0.004}}}}, found {given!r}")
    parts = []
    for kind, values in given.items():
        if kind not in FIELDS:
            raise PlanError(f"{field}: no shape '{kind}'; there are {', '.join(FIELDS)}")
        if not isinstance(values, dict) or set(values) - FIELDS[kind] or NEEDED[kind] - set(values):
            raise PlanError(f"{field}.{kind}: expected {', '.join(sorted(FIELDS[kind]))}, found {values!r}")
        parts.append(MAKERS[kind](f"{field}.{kind}", values))
    return parts


def sphere(field, values):
    center, radius = vector(f"{field}.center", values["center"]), positive(f"{field}.radius", values["radius"])
    return lambda points: np.linalg.norm(points - center, axis=1) - radius


def box(field, values):
    low = bounds(f"{field}.min", values.get("min", [-math.inf] * 3))
    high = bounds(f"{field}.max", values.get("max", [math.inf] * 3))
    if np.any(low >= high):
        raise PlanError(f"{field}: expected min below max, found {values!r}")

    def distances(points):
        beyond = np.maximum(low - points, points - high)
        return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)
    return distances


def half_space(field, values):
    point, normal = vector(f"{field}.point", values["point"]), vector(f"{field}.normal", values.get("normal", [0, 0, 1]))
    if not np.any(normal):
        raise PlanError(f"{field}.normal: expected a direction, found zeros")
    normal /= np.linalg.norm(normal)
    return lambda points: (points - point) @ normal


def cylinder(field, values):
    begin, end = vector(f"{field}.from", values["from"]), vector(f"{field}.to", values["to"])
    radius, length = positive(f"{field}.radius", values["radius"]), np.linalg.norm(end - begin)
    if length == 0:
        raise PlanError(f"{field}: expected two different ends, found {values!r}")
    axis = (end - begin) / length

    def distances(points):
        along = (points - begin) @ axis
        aside = np.linalg.norm(points - begin - along[:, None] * axis, axis=1) - radius
        beyond = np.stack([aside, np.maximum(-along, along - length)], axis=1)
        return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)
    return distances


MAKERS = {"sphere": sphere, "box": box, "half_space": half_space, "cylinder": cylinder}


def vector(field, value):
    return np.array(named(field, lambda: check_vector(field, value)))


def bounds(field, value):
    try:
        three = np.array([float(each) for each in value])
    except (TypeError, ValueError):
        three = np.zeros(0)
    if three.shape != (3,) or np.any(np.isnan(three)):
        raise PlanError(f"{field}: expected 3 numbers, found {value!r}")
    return three


def positive(field, value):
    check_positive(field, value)
    return float(value)
