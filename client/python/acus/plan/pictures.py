# SPDX-License-Identifier: MIT
"""What a plan looks like. Needs matplotlib."""

import numpy as np

from ..study.pictures import BLUE, GREY, MM, ORANGE, figure, save
from .shapes import region_of

GREEN, RED = "#009e73", "#cc0000"
LOOK = 4e-4  # m between places at which it is looked for what is to be avoided
ROOM = 8e-3  # m around what is drawn


def draw(plans, plan, path):
    """Two cuts along the needle, as it is bent: what it touches there it touches. The first is through the nearest place to
    avoid, or the plane in which it bends."""
    problem, known = plans.problem, [each for each in plan.outcomes if each is not None]
    direction, entry = np.array(plan.motion.direction), np.array(plan.motion.entry)
    side = sideways(problem, direction, entry, plan.nominal or (known or [None])[0])
    points = np.concatenate([*(each.shaft for each in known), [problem.target, entry]])
    sides = [np.stack([direction, right]) for right in (side, np.cross(direction, side))]
    corners = [limits(problem, points, entry, basis) for basis in sides]
    heights = [high[1] - low[1] for low, high in corners]
    made, axes = figure(10, 1.9 + 9 * sum(heights) / (corners[0][1] - corners[0][0])[0], 2, 1, height_ratios=heights)
    for place, basis, (low, high) in zip(axes[:, 0], sides, corners):
        draw_side(place, plans, plan, known, Side(entry, basis, low, high))
    axes[1, 0].legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.3), ncols=6)
    nearest = min(plan.clearance, key=plan.clearance.get, default=None)
    clear = f", at least {MM * plan.clearance[nearest]:.1f} mm from {nearest}" if nearest else ""
    made.suptitle(f"succeeds in {plan.probability:.0%} of {len(plan.outcomes)} samples ({plan.interval[0]:.0%} to {plan.interval[1]:.0%}), "
                  f"mean miss {MM * plan.miss:.2f} mm{clear}, largest force {plan.force:.2f} N", fontsize=10)
    save(made, path)


def sideways(problem, direction, entry, outcome):
    """Across the direction: towards the nearest place to avoid, else to where the needle bends most."""
    way = outcome.shaft if outcome is not None and len(outcome.shaft) else entry[None]
    if problem.avoid:
        distances = {name: place.distances(problem.model, way) for name, place in problem.avoid}
        name = min(distances, key=lambda each: distances[each].min())
        at = way[np.argmin(distances[name])]
        steps = np.concatenate([1e-4 * np.eye(3), -1e-4 * np.eye(3)])
        found = dict(problem.avoid)[name].distances(problem.model, at + steps)
        far = found[3:] - found[:3]
    else:
        aside = way - entry - ((way - entry) @ direction)[:, None] * direction
        far = aside[np.argmax(np.linalg.norm(aside, axis=1))]
    far = far - (far @ direction) * direction
    if np.linalg.norm(far) < 1e-5:
        far = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    return far / np.linalg.norm(far)


def limits(problem, points, entry, basis):
    """Corners (mm) of what is drawn."""
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
        draw_cut(axes, problem, place, side, plan.nominal)
        axes.fill([], [], color=ORANGE, alpha=0.35, label=f"avoid: {name}")
    for each in known:
        axes.plot(*side.flat(each.shaft), color=GREY if plan.succeeds(each) else RED, linewidth=0.6, alpha=0.7)
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
    axes.set_xlabel("along the direction (mm)", labelpad=2)
    axes.set_ylabel("aside (mm)")


def draw_cut(axes, problem, place, side, nominal):
    """What is to be avoided, in the surface through the needle that stands upright on the picture; at rest."""
    x, y = (np.arange(low, high, MM * LOOK) for low, high in zip(side.low, side.high))
    x, y = np.meshgrid(x, y)
    upright = np.cross(*side.basis)
    deep = np.zeros_like(x)
    if nominal is not None and len(nominal.shaft) > 1:
        along = MM * (nominal.shaft - side.origin) @ side.basis[0]
        deep = np.interp(x, along, MM * (nominal.shaft - side.origin) @ upright)
    places = side.origin + (np.stack([x.ravel(), y.ravel()], axis=1) @ side.basis + deep.ravel()[:, None] * upright) / MM
    if place.region is None:
        distances = place.distances(problem.model, places)
    else:
        within, _ = region_of(problem.model, place.region)
        distances = np.array([-1.0 if within.find(each) is not None else 1.0 for each in places])
    distances = distances.reshape(x.shape)
    if distances.min() < 0:
        axes.contourf(x, y, distances, levels=[distances.min() - 1, 0], colors=[ORANGE], alpha=0.35)
    if distances.min() < 0 < distances.max():
        axes.contour(x, y, distances, levels=[0], colors=[ORANGE], linewidths=1.2)


def surface_line(problem, plan, side):
    """The tissue's surface beside the entry."""
    direction = np.array(plan.motion.direction)
    found = [problem.surface.hit(np.array(plan.motion.entry) + share * side.basis[1], direction) for share in np.linspace(-0.05, 0.05, 101)]
    return [each[0] for each in found if each is not None]
