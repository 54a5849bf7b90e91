# SPDX-License-Identifier: MIT
"""Cuts through the tissue by a plane, with the needles seen along its normal."""

import matplotlib.patheffects as effects
import numpy as np
from matplotlib.collections import PolyCollection

from .. import shapes
from ..rotation import axis_of
from .run_curves import EVENT_MARKERS, EVENT_STYLE, MM

BESIDE = 0.5  # of the tissue's size: how far beside it a needle is still shown
REGION_COLOURS = ["#f3dcc0", "#bcd9ee", "#c4e5d6", "#ecc9dd", "#f5eda6", "#cfcfcf"]  # pale ones of Okabe and Ito's
OUTLINE = {"edgecolor": "#8a7f74", "linewidth": 0.25}
HALO = [effects.withStroke(linewidth=3.6, foreground="white")]
NEEDLE_STYLE = {"linewidth": 2.0, "solid_capstyle": "butt"}
NEEDLE_COLOURS = {True: "#111111", False: "#777777"}  # whether it is the one whose forces are drawn
BASE_STYLE = {"marker": "s", "markersize": 6, "linestyle": "none"}
PATH_STYLE = {"color": "#d55e00", "linewidth": 1.0}
GUIDE_STYLE = {"color": "#7a3e8e", "linewidth": 2.5, "solid_capstyle": "butt"}


def unit(v):
    return v / np.linalg.norm(v)


class View:
    """A plane to cut with, and how it lies on the paper: right and up are unit vectors of the world."""

    def __init__(self, point, normal, axis):
        self.point = point
        self.normal = normal / np.linalg.norm(normal)
        upward = np.array([0.0, 0.0, 1.0])
        if abs(self.normal[2]) < 0.8:
            self.up = unit(upward - upward @ self.normal * self.normal)
            self.right = np.cross(self.up, self.normal)
        else:  # seen from above or below: the needle runs to the right
            self.right = unit(axis - axis @ self.normal * self.normal)
            self.up = np.cross(self.normal, self.right)
        if self.right[np.argmax(np.abs(self.right))] < 0:  # look from the side where the axes grow to the right
            self.right, self.normal = -self.right, -self.normal

    def flat(self, points):
        """Places on the paper (mm)."""
        return np.stack([points @ self.right, points @ self.up], axis=-1) * MM

    @staticmethod
    def label(direction):
        """The direction in terms of the world's axes, such as 0.67 x + 0.74 y."""
        terms = [(round(float(share), 2), axis) for share, axis in zip(direction, "xyz") if abs(share) > 0.03]
        text = " + ".join(axis if share == 1 else f"−{axis}" if share == -1 else f"{share:.2g} {axis}"
                          for share, axis in terms)
        return text.replace("+ -", "− ").replace("-", "−") + " (mm)"


def draw_view(axes, view, moment, recorded, events, needle):
    frame = moment.frame
    polygons, owners = shapes.cut(frame.tissue, recorded.tetrahedra, view.point, view.normal)
    colours = [region_colour(recorded.region_of[owner]) for owner in owners]
    outlines = [view.flat(frame.dents.outline(polygon)) for polygon in polygons]
    axes.add_collection(PolyCollection(outlines, facecolors=colours, **OUTLINE))
    for name, (nodes, _) in frame.needles.items():
        flat, colour = view.flat(nodes), NEEDLE_COLOURS[name == needle]
        axes.plot(*flat.T, color=colour, path_effects=HALO, **NEEDLE_STYLE)
        axes.plot(*flat[0], color=colour, **BASE_STYLE)
    for path in frame.paths:
        axes.plot(*view.flat(path).T, **PATH_STYLE)
    for position, orientation in frame.guides.values():
        draw_guide(axes, view, position, orientation)
    for event in events:
        if np.all(np.isfinite(event.position)):
            axes.plot(*view.flat(event.position), EVENT_MARKERS.get(event.kind, "x"), markersize=6, zorder=6,
                      **EVENT_STYLE)


def region_colour(region):
    return REGION_COLOURS[region % len(REGION_COLOURS)]


def draw_guide(axes, view, position, orientation):
    """The two sides of the hole."""
    place, along = view.flat(position), view.flat(axis_of(orientation)) / MM
    across = np.array([-along[1], along[0]])
    for side in (-1.8, 1.8):  # mm
        axes.plot(*np.stack([place + side * across - 3 * along, place + side * across + 3 * along]).T, **GUIDE_STYLE)


def limits_of(view, moments):
    """What all views show (mm): the tissue, and the needles as far as they are not far beside it."""
    tissue = np.concatenate([view.flat(moment.frame.tissue) for moment in moments])
    nodes = np.concatenate([view.flat(nodes) for moment in moments for nodes, _ in moment.frame.needles.values()])
    centre = tissue if tissue.size else nodes
    low, high = centre.min(axis=0), centre.max(axis=0)
    size = max(high - low)
    low, high = np.minimum(low, np.maximum(nodes.min(axis=0), low - BESIDE * size)), \
        np.maximum(high, np.minimum(nodes.max(axis=0), high + BESIDE * size))
    margin = 0.04 * size
    return low - margin, high + margin
