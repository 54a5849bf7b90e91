# SPDX-License-Identifier: MIT
"""Draws a recorded run as one picture: side views of the tissue at a few moments, the forces under them. Prints how far
each region moved.

Record a run, then draw it:

    acus-replay motion.csv --lockstep --out run.csv --shapes run.shapes
    acus-picture run.csv                                 # run.png: first contact, half way in, deepest, end
    acus-picture run.csv --times 2,3.5,8 --out run.svg   # moments of your choice, in seconds from the start
    acus-picture run.csv --normal 0,1,0                  # seen along y

Each view is a cut through the deformed tissue by one plane, the same at all moments. Tissue is drawn as the plane cuts
its tetrahedra, with the dents around needles (acus.Dents), in a colour per region; needles, the paths they cut, guides,
and the events since the view before are seen along the plane's normal, wherever they are. The plane holds the axis of
the needle and the direction in which it strays furthest from it; a needle that stays straight, within 3 % of its length,
gets the plane of its neighbours or an upright one. The axes of a view are labelled with their directions in the world.

A region has moved as far as its centroid, the mean over its tetrahedra, weighted with their volumes at rest. The table
that is printed holds the largest displacement of each region from its place at rest over the whole run, and when it was
reached; the picture names the regions that moved more than 0.1 mm.

Forces are of one needle (--needle), the views show all. Axial resistance is what the holder feels along the needle,
positive when the tissue resists going in; its parts and the lateral force come from the same file. Events are read from
run.events.csv beside run.csv if it exists; those of a kind that follow each other at once are drawn once.
"""

import argparse
import os
import sys
import textwrap

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

import acus  # noqa: E402
from acus import shapes  # noqa: E402
from acus.drawing import cuts, figures, run_curves  # noqa: E402
from acus.drawing.run_curves import MM  # noqa: E402
from acus.rotation import axis_of  # noqa: E402

STRAIGHT = 0.03  # of its length: a needle that strays less from its axis has no plane of its own
FEWEST_SHAPES = 2  # between two moments, for them to be worth two views
ALMOST = 0.999  # of the largest depth counts as deepest: at rest the depth still creeps
BEYOND = 0.5  # s, that a time asked for may lie before the first or after the last shape
MOVED = 1e-4  # m, a displacement worth a word in the picture
LINE = 150  # characters, that fit across the picture
LETTERS = "abcdefgh"  # of the views, and with them their largest number
WIDTH = 13.0  # inches, of the picture
FORCE_HEIGHT = 3.2  # inches, of the curves
HEADING_HEIGHT = 0.65  # inches, of the title and displacements under it
TEXT_HEIGHT = 0.35  # inches, of a title alone, and of the legend between views and curves
VIEW_HEIGHTS = (1.6, 6.0)  # inches, least and most of the views


class Moment:
    """A time (s from the start of the run) worth a view."""

    def __init__(self, time, title):
        self.time = time
        self.title = title
        self.frame = None


# ---- Which moments ----


def chosen_moments(curves, recorded, times):
    first, last = (recorded.tissue[i][0] - curves.start for i in (0, -1))
    for time in times or []:
        if not first - BEYOND <= time <= last + BEYOND:
            raise acus.RunError(f"--times: expected times from {max(first, 0):.3g} to {last:.3g} s, found {time:g}")
    moments = [Moment(time, "") for time in times] if times else typical_moments(curves)
    for moment in moments:
        moment.frame = recorded.frame(moment.time + curves.start)
        moment.time = moment.frame.time - curves.start
    spacing = FEWEST_SHAPES * (last - first) / max(len(recorded.tissue) - 1, 1)
    return moments if times else apart(moments, spacing)


def typical_moments(curves):
    end = Moment(curves.time[-1], "end")
    touching = np.flatnonzero(curves.touched)
    if not touching.size:
        return [Moment(curves.time[0], "start"), end]
    contact = int(touching[0])
    most = np.max(curves.inserted)
    if most <= 0:
        return [Moment(curves.time[contact], "first contact"), end]
    half, deepest = (int(np.argmax(curves.inserted >= share * most)) for share in (0.5, ALMOST))
    moments = [Moment(curves.time[contact], "first contact"), Moment(curves.time[half], "half way in")]
    if curves.inserted[-1] < ALMOST * most:
        moments.append(Moment(curves.time[deepest], "deepest"))
    return [*moments, end]


def apart(moments, spacing):
    """Without those that show the same as the one before."""
    kept = []
    for moment in moments:
        if not kept or moment.time - kept[-1].time >= spacing:
            kept.append(moment)
    return kept


# ---- Which plane ----


def chosen_view(curves, moments, normal):
    """The plane through the needle's axis, at the moment of its largest excursion, or with a given normal."""
    excursions = [excursion_of(moment.frame, curves.needle) for moment in moments]
    point, axis, aside = max(excursions, key=lambda excursion: np.linalg.norm(excursion[2]))
    if normal is not None:
        return cuts.View(point, normal, axis)
    least = STRAIGHT * shapes.span_of(moments[0].frame.needles[curves.needle][0])
    if np.linalg.norm(aside) < least:
        aside = towards_neighbours(moments[0].frame, curves.needle, axis)
    if np.linalg.norm(aside) < least:
        across = np.array([1.0, 0, 0] if abs(axis[2]) > 0.9 else [0, 0, 1.0])  # a view from the side
        aside = across - across @ axis * axis
    return cuts.View(point, np.cross(axis, aside), axis)


def excursion_of(frame, needle):
    """Where the needle's base is, its axis there, and how far and where to it strays from that line at most."""
    nodes, orientations = frame.needles[needle]
    axis = cuts.unit(axis_of(orientations[0]))
    return nodes[0], axis, furthest(nodes - nodes[0], axis)


def towards_neighbours(frame, needle, axis):
    others = [nodes for name, (nodes, _) in frame.needles.items() if name != needle]
    if not others:
        return np.zeros(3)
    return furthest(np.concatenate(others) - frame.needles[needle][0][0], axis)


def furthest(offsets, axis):
    aside = offsets - np.outer(offsets @ axis, axis)
    return aside[np.argmax(np.linalg.norm(aside, axis=1))]


# ---- How far the tissue moved ----


def print_displacements(displacements, start):
    if not displacements:
        return  # no tissue
    width = max(len("region"), *(len(each.region) for each in displacements))
    print(f"{'region':{width}}  moved at most (mm)  at (s)")
    for each in displacements:
        print(f"{each.region:{width}}  {each.distance * MM:18.3f}  {each.time - start:6.2f}")


def in_words(displacements, start):
    """Those worth a word, the largest first, as one line; nothing if there are none."""
    moved = sorted((each for each in displacements if each.distance > MOVED), key=lambda each: -each.distance)
    if not moved:
        return ""
    terms = ", ".join(f"{each.region} {each.distance * MM:.2f} mm at {each.time - start:.2f} s" for each in moved)
    return textwrap.shorten("Centroids moved at most: " + terms, LINE, placeholder=" …")


# ---- Drawing ----


def draw_views(figure, cells, view, moments, recorded, events, curves):
    low, high = cuts.limits_of(view, moments)
    first, earlier = None, -np.inf
    for letter, cell, moment in zip(LETTERS, cells, moments):
        axes = figure.add_subplot(cell, sharex=first, sharey=first)
        recent = [event for event in events if earlier < event.time <= moment.time]
        cuts.draw_view(axes, view, moment, recorded, recent, curves.needle)
        earlier = moment.time
        axes.set_aspect("equal")
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        axes.set_xlabel(view.label(view.right))
        axes.tick_params(labelsize=8)
        if first is None:
            first = axes
            axes.set_ylabel(view.label(view.up))
        else:
            axes.tick_params(labelleft=False)
        depth = curves.inserted[curves.row_at(moment.time)] * MM
        title = f"{letter}  {moment.title}" + (", " if moment.title else "") + f"{moment.time:.2f} s"
        axes.set_title(f"{title}\n{depth:.1f} mm inside", fontsize=9.5, loc="left")


def draw_curves(axes, curves, moments, events):
    run_curves.draw_forces(axes, curves, events)
    kind = "inserted" if np.any(curves.inserted > 0) else "travel"
    handles = run_curves.draw_depth(axes, curves, run_curves.depth_of(curves, kind), run_curves.DEPTH_LABELS[kind])
    run_curves.draw_grid(axes)
    for letter, moment in zip(LETTERS, moments):
        axes.axvline(moment.time, color="#777777", linewidth=0.8, linestyle=":")
        axes.annotate(letter, (moment.time, 1), xycoords=("data", "axes fraction"), xytext=(0, 3),
                      textcoords="offset points", ha="center", fontsize=9.5)
    axes.legend(*handles, loc="center left", bbox_to_anchor=(1.08, 0.5), frameon=False, fontsize=9)


def legend_of_views(axes, recorded, moments):
    used = np.unique(recorded.region_of)
    handles = [Patch(facecolor=cuts.region_colour(i), label=recorded.regions[i], **cuts.OUTLINE) for i in used]
    handles.append(Line2D([], [], label="needle, base", marker="s", markersize=6, color=cuts.NEEDLE_COLOURS[True],
                          **cuts.NEEDLE_STYLE))
    if len(recorded.needles) > 1:
        handles.append(Line2D([], [], label="other needles", color=cuts.NEEDLE_COLOURS[False], **cuts.NEEDLE_STYLE))
    if any(moment.frame.paths for moment in moments):
        handles.append(Line2D([], [], label="path", **cuts.PATH_STYLE))
    if recorded.hello["guides"]:
        handles.append(Line2D([], [], label="guide", **cuts.GUIDE_STYLE))
    axes.axis("off")
    axes.legend(handles=handles, loc="center", ncols=8, frameon=False, fontsize=9)


def draw(curves, recorded, view, moments, events, heading):
    """`heading` is the title and the line under it."""
    low, high = cuts.limits_of(view, moments)
    width, height = high - low
    view_height = float(np.clip((WIDTH - 1) / len(moments) * height / width, *VIEW_HEIGHTS))
    heights = [HEADING_HEIGHT if heading[1] else TEXT_HEIGHT, view_height + 0.9, TEXT_HEIGHT, FORCE_HEIGHT]
    figure = plt.figure(figsize=(WIDTH, sum(heights)), constrained_layout=True)
    rows = figure.add_gridspec(len(heights), 1, height_ratios=heights)
    top = figure.add_subplot(rows[0])
    top.axis("off")
    top.text(0, 1, heading[0], fontsize=13, va="top")
    top.text(0, 0.2, heading[1], fontsize=9.5, va="bottom")
    cells = rows[1].subgridspec(1, len(moments))
    draw_views(figure, [cells[i] for i in range(len(moments))], view, moments, recorded, events, curves)
    legend_of_views(figure.add_subplot(rows[2]), recorded, moments)
    draw_curves(figure.add_subplot(rows[3]), curves, moments, events)
    return figure


# ---- Arguments ----


def numbers(text):
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected numbers with commas between, found '{text}'") from None
    if not np.all(np.isfinite(values)):
        raise argparse.ArgumentTypeError(f"expected finite numbers, found '{text}'")
    return values


def direction(text):
    values = np.array(numbers(text))
    if values.shape != (3,) or not np.any(values):
        raise argparse.ArgumentTypeError(f"expected x,y,z that are not all zero, found '{text}'")
    return values


def times(text):
    values = sorted(set(numbers(text)))
    if len(values) > len(LETTERS):
        raise argparse.ArgumentTypeError(f"expected at most {len(LETTERS)} times, found {len(values)}")
    return values


def parse_arguments():
    parser = argparse.ArgumentParser(prog="acus-picture", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", help="CSV written by acus-replay --out")
    parser.add_argument("--shapes", help="written by acus-replay --shapes (default: the run's name with .shapes)")
    parser.add_argument("--out", help="picture to write, .png, .svg or .pdf (default: the run's name with .png)")
    parser.add_argument("--needle", help="whose forces and whose plane (default: the one of the first row)")
    parser.add_argument("--times", type=times, metavar="T1,T2,...",
                        help="moments to show, s from the start of the run, at most 8 (default: chosen from the run)")
    parser.add_argument("--normal", type=direction, metavar="X,Y,Z",
                        help="of the cutting plane, world, any length; --normal=-1,0,0 if it begins with a minus "
                             "(default: across the plane in which the needle bends)")
    parser.add_argument("--title", help="default: the name of the scene")
    return parser.parse_args()


def draw_run(arguments):
    stem = os.path.splitext(arguments.run)[0]
    with acus.Run(arguments.run, arguments.shapes) as whole, run_curves.last_epoch(whole) as run:
        curves = run_curves.Curves(run, arguments.needle)
        events = run_curves.events_to_draw(run, curves)
        recorded = run.shapes
        if curves.needle not in recorded.needles:
            raise acus.RunError(f"{recorded.path}: has no needle '{curves.needle}', so it is of another run than "
                                f"{arguments.run}")
        moments = chosen_moments(curves, recorded, arguments.times)
        displacements = recorded.displacements()
    view = chosen_view(curves, moments, arguments.normal)
    title = arguments.title or recorded.hello["scene"]
    if len(recorded.needles) > 1:
        title += f" (forces on '{curves.needle}')"
    heading = (title, in_words(displacements, curves.start))
    figures.save(draw(curves, recorded, view, moments, events, heading), arguments.out or stem + ".png")
    print_displacements(displacements, curves.start)


def main():
    try:
        draw_run(parse_arguments())
    except acus.AcusError as error:
        sys.exit(str(error))
