# SPDX-License-Identifier: MIT
"""What a plan looks like. Needs matplotlib."""

import numpy as np

from ..study.pictures import BLUE, GREY, MM, ORANGE, figure, save
from .tissue import boundary_of, tetrahedra_of

GREEN, RED = "#009e73", "#cc0000"
GRID, SLICES = 160, 81  # places along a side and in depth, at which distances to shapes are taken
DEPTH = 0.06  # m before and behind the entry, across it
ROOM = 8e-3  # m around what is drawn


def draw(plans, plan, path):
    problem, known = plans.problem, [each for each in plan.outcomes if each is not None]
    direction, entry = np.array(plan.motion.direction), np.array(plan.motion.entry)
    side = sideways(direction, entry, known)
    points = np.concatenate([*(each.shaft for each in known), [problem.target, entry]])
    sides = [np.stack([direction, right]) for right in (side, np.cross(direction, side))]
    corners = [limits(problem, points, entry, basis) for basis in sides]
    heights = [high[1] - low[1] for low, high in corners]
    made, axes = figure(10, 2.2 + 9 * sum(heights) / (corners[0][1] - corners[0][0])[0], 2, 1, height_ratios=heights)
    for place, basis, (low, high) in zip(axes[:, 0], sides, corners):
        draw_side(place, plans, plan, known, Side(entry, basis, low, high))
    axes[1, 0].legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.45), ncols=6)
    axes[0, 0].set_xlabel("")
    made.suptitle(f"succeeds in {plan.probability:.0%} of {len(plan.outcomes)} samples ({plan.interval[0]:.0%} to {plan.interval[1]:.0%}), "
                  f"mean miss {MM * plan.miss:.2f} mm, largest force {plan.force:.2f} N", fontsize=10)
    save(made, path)


def sideways(direction, entry, known):
    """Across the direction, to where the needle bends most."""
    way = known[0].shaft - entry if known and len(known[0].shaft) else np.zeros((1, 3))
    aside = way - (way @ direction)[:, None] * direction
    far = aside[np.argmax(np.linalg.norm(aside, axis=1))]
    if np.linalg.norm(far) < 1e-4:
        far = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    return far / np.linalg.norm(far)


def limits(problem, points, entry, basis):
    """Corners (mm) of what is drawn: all points, and of shapes to avoid what lies near."""
    flat = MM * (points - entry) @ basis.T
    return flat.min(axis=0) - MM * ROOM - [0, MM * problem.radius], flat.max(axis=0) + MM * ROOM + [0, MM * problem.radius]


class Side:
    """`origin` m; `basis` to the right and up, 2 x 3; corners, mm."""

    def __init__(self, origin, basis, low, high):
        self.origin, self.basis, self.low, self.high = origin, basis, low, high

    def flat(self, points):
        """x and y, mm."""
        return (MM * (np.asarray(points) - self.origin) @ self.basis.T).T


def draw_side(axes, plans, plan, known, side):
    problem = plans.problem
    for name, place in problem.avoid:
        draw_silhouette(axes, problem, place, side)
        axes.plot([], [], color=ORANGE, label=f"avoid: {name}")
    for each in known:
        fits = each.margin > 0 and np.linalg.norm(each.miss) <= problem.radius
        axes.plot(*side.flat(each.shaft), color=GREY if fits else RED, linewidth=0.6, alpha=0.7)
    if plan.nominal is not None:
        axes.plot(*side.flat(plan.nominal.shaft), color=BLUE, linewidth=1.6, label="needle, in the scene as it is")
    axes.plot([], [], color=GREY, label="in samples that succeed")
    axes.plot([], [], color=RED, label="in samples that fail")
    surface = surface_line(problem, plan, side)
    if len(surface) > 1:
        axes.plot(*side.flat(surface), color="black", linewidth=0.8)
    angle, (x, y) = np.linspace(0, 2 * np.pi, 60), side.flat([problem.target])
    axes.plot(x + MM * problem.radius * np.cos(angle), y + MM * problem.radius * np.sin(angle), color=GREEN, linewidth=1.5, label="target")
    axes.plot(*side.flat([plan.motion.entry]), ">", color="black", markersize=6, label="entry")
    axes.set_xlim(side.low[0], side.high[0])
    axes.set_ylim(side.low[1], side.high[1])
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel("along the direction (mm)")
    axes.set_ylabel("aside (mm)")


def draw_silhouette(axes, problem, place, side):
    """What can be seen of a place to avoid, at rest."""
    if place.region is not None:
        from matplotlib.collections import PolyCollection  # pylint: disable=import-outside-toplevel  # with figure()
        triangles = problem.model.rest_positions[boundary_of(tetrahedra_of(problem.model, place.region))]
        axes.add_collection(PolyCollection([side.flat(each).T for each in triangles], facecolor=ORANGE, alpha=0.15))
        return
    x, y = np.meshgrid(np.linspace(side.low[0], side.high[0], GRID), np.linspace(side.low[1], side.high[1], GRID))
    places = side.origin + np.stack([x.ravel(), y.ravel()], axis=1) / MM @ side.basis
    depths = np.linspace(-DEPTH, DEPTH, SLICES)[:, None] * np.cross(*side.basis)
    nearest = np.min([place.distances(problem.model, places + depth) for depth in depths], axis=0).reshape(x.shape)
    if nearest.min() < 0:
        axes.contourf(x, y, nearest, levels=[nearest.min() - 1, 0], colors=[ORANGE], alpha=0.35)
    if nearest.min() < 0 < nearest.max():
        axes.contour(x, y, nearest, levels=[0], colors=[ORANGE], linewidths=1.2)


def surface_line(problem, plan, side):
    """The tissue's surface beside the entry."""
    direction = np.array(plan.motion.direction)
    found = [problem.surface.hit(np.array(plan.motion.entry) + share * side.basis[1], direction) for share in np.linspace(-0.05, 0.05, 101)]
    return [each[0] for each in found if each is not None]
