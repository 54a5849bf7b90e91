# SPDX-License-Identifier: GPL-3.0-or-later
"""Tells what insertions came to: a table against limits, distributions, and pictures of the worst."""

import dataclasses
import os

import matplotlib
import numpy as np

from insertions.draw import draw
from insertions.measure import run

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  pylint: disable=wrong-import-position

WORST = 10
AROUND = 40  # ticks of a picture on either side


@dataclasses.dataclass(frozen=True)
class Limit:
    """Of a share of the runs."""
    what: str
    most: float  # share of the runs
    breaks: object  # of a run's figures: whether it counts


LIMITS = (
    Limit("a force that is no number", 0, lambda row: not row["finite"]),
    Limit("a puncture while the needle is drawn or pulls", 0, lambda row: row["punctures_drawn"] > 0),
    Limit("a step of the base force without event before it, or flag", 0.03, lambda row: row["steps"] > 0 and not row["step_flags"]),
    Limit("such a step, flagged", 0.05, lambda row: row["steps"] > 0 and row["step_flags"]),
    Limit("more than 1 mm of shaft unheld", 0.02, lambda row: row["unheld"] > 1e-3),
    Limit("more than 3 mm of shaft unheld", 0.01, lambda row: row["unheld"] > 3e-3),
    Limit("a tip more than 0.2 mm below the drawn skin", 0.02, lambda row: row["under_skin"] > 2e-4),
    Limit("a tip more than 0.5 mm below the drawn skin", 0.005, lambda row: row["under_skin"] > 5e-4),
    Limit("work of the hand below zero", 0.01, lambda row: row["work"] < -1e-6),
)


def judged(rows):
    """[(Limit, numbers of the runs that count)]."""
    return [(limit, [row["number"] for row in rows if limit.breaks(row)]) for limit in LIMITS]


def table(rows):
    lines = [f"{len(rows)} insertions", "", "| runs with | share | at most | numbers |", "|---|---|---|---|"]
    for limit, numbers in judged(rows):
        shown = ", ".join(map(str, numbers[:WORST])) + (", ..." if len(numbers) > WORST else "")
        lines.append(f"| {limit.what} | {len(numbers) / len(rows):.1%} | {limit.most:.0%} | {shown} |")
    flags = {}
    for row in rows:
        for flag in row["flags"].split():
            flags[flag] = flags.get(flag, 0) + 1
    lines += ["", "| flag | runs |", "|---|---|"] + [f"| {flag} | {count} |" for flag, count in sorted(flags.items(), key=lambda each: -each[1])]
    return "\n".join(lines) + "\n"


def holds(rows):
    return all(len(numbers) <= limit.most * len(rows) for limit, numbers in judged(rows))


def draw_distributions(rows, path):
    """How many runs are beyond a value, of each figure."""
    figures = (("step over the largest force", [row["step"] / max(row["largest"], 1e-9) for row in rows], None),
               ("unheld (mm)", [1e3 * row["unheld"] for row in rows], 1),
               ("tip below the drawn skin (mm)", [1e3 * row["under_skin"] for row in rows], 0.2))
    figure, axes = plt.subplots(1, len(figures), figsize=(12, 3.5))
    for axis, (name, values, goal) in zip(axes, figures):
        axis.step(np.sort(values)[::-1], np.arange(1, len(values) + 1) / len(values), where="post")
        axis.set(xlabel=name, ylabel="share of the runs beyond", yscale="log")
        if goal is not None:
            axis.axvline(goal, color="0.6", linewidth=0.8)
        axis.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_worst(rows, path):
    """The base's force around the largest steps, against those of the whole run."""
    worst = sorted((row for row in rows if row["steps"]), key=lambda row: -row["step"] / row["largest"])[:WORST]
    if not worst:
        return
    figure, axes = plt.subplots(len(worst), 2, figsize=(12, 2.2 * len(worst)), squeeze=False)
    for (whole, near), row in zip(axes, worst):
        course = run(draw(row["number"]), looks=False)
        size, at = np.linalg.norm(course.forces, axis=1), row["step_tick"]
        for axis, first, last in ((whole, 0, len(size)), (near, max(0, at - AROUND), min(len(size), at + AROUND))):
            ticks = np.arange(first, last)
            axis.plot(ticks, size[first:last], "k.-", markersize=2, linewidth=0.7)
            for tick, kind, _ in course.events:
                if first <= tick < last:
                    axis.axvline(tick, color="tab:orange", linewidth=0.7)
                    axis.annotate(kind, (tick, axis.get_ylim()[1]), fontsize=6, rotation=90, va="top")
            axis.axvline(at, color="tab:red", linestyle=":", linewidth=0.7)
            axis.set_ylabel("N", fontsize=7)
            axis.tick_params(labelsize=7)
        whole.set_title(f"{row['number']}: {row['mesh']}, {row['needle']} {row['tip']}, {row['tilt']:.0f} degrees, {row['rate']} Hz", fontsize=8)
        near.set_title(f"tick {at}: {row['step']:.2g} N {row['step_flags']} {'before ' + row['step_follows'] if row['step_follows'] else ''}", fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=90)
    plt.close(figure)


def write(rows, folder):
    """insertions.md with its pictures. Returns its text."""
    text = table(rows)
    draw_distributions(rows, os.path.join(folder, "distributions.png"))
    draw_worst(rows, os.path.join(folder, "worst.png"))
    with open(os.path.join(folder, "insertions.md"), "w", encoding="utf-8") as file:
        file.write(text + "\n![](distributions.png)\n\n![](worst.png)\n")
    return text
