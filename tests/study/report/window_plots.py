# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against run time of deferred fields, from windows.csv (tests/study/studies/study.h)."""

import matplotlib.pyplot as plt
from page import Section
from tables import values, where

FELT = {"force_p95": 1e-3, "force_p99": 3e-3, "tip_p95": 10e-6}  # N, N, m: what a window of 16 ms should hold
STANDARD = 16  # ticks of 1 ms
LABELS = {"force_p95": ("base force, 95 of 100 ticks (mN)", 1e3), "force_p99": ("base force, 99 of 100 ticks (mN)", 1e3),
          "tip_p95": ("tip, 95 of 100 ticks (µm)", 1e6)}


def front_figure(rows):
    figure, all_axes = plt.subplots(1, len(LABELS), figsize=(6 * len(LABELS), 4.6), layout="constrained")
    scenes = values(rows, "scene")
    for axes, (column, (label, scale)) in zip(all_axes, LABELS.items()):
        for i, scene in enumerate(scenes):
            line = [row for row in where(rows, scene=scene) if row["window"] > 0]
            axes.plot([row["run_time"] for row in line], [max(scale * row[column], 1e-3) for row in line], marker="o",
                      markersize=4, linewidth=1, color=f"C{i % 10}", linestyle="-" if i < 10 else "--", label=scene)
            for row in line[:: max(len(line) - 1, 1)]:
                axes.annotate(f"{row['window']:.0f}", (row["run_time"], max(scale * row[column], 1e-3)),
                              textcoords="offset points", xytext=(3, 3), fontsize=7, color="#555555")
        axes.axhline(scale * FELT[column], color="#d55e00", linewidth=1)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("processor seconds per simulated second")
        axes.set_ylabel(label)
    all_axes[0].legend(frameon=False, fontsize=7)
    return figure


def as_table(rows):
    without = {row["scene"]: row for row in where(rows, window=0)}
    return [{"scene": row["scene"], "nodes": row["nodes"], "k": row["window"], "force p50 (mN)": 1e3 * row["force_p50"],
             "p95": 1e3 * row["force_p95"], "p99": 1e3 * row["force_p99"], "largest": 1e3 * row["force_max"],
             "tip p95 (µm)": 1e6 * row["tip_p95"], "time, of k = 0": row["run_time"] / without[row["scene"]]["run_time"],
             "tick p99 / p50": row["ms_p99"] / row["ms_p50"], "held back (%)": 100 * row["held_back"]}
            for row in rows if row["window"] > 0]


def sections(folder):
    rows = folder.read("windows.csv")
    if not rows:
        return []
    refused = [row for row in rows if row["refused"]]
    rows = [row for row in rows if not row["refused"]]
    over = sorted({row["scene"] for row in where(rows, window=STANDARD) if any(row[c] > FELT[c] for c in FELT)})
    section = Section("Deferred fields", (
        "Every scene along its own motion at 1 kHz with a window of k ticks (tissue.window), against k = 0. "
        f"At k = {STANDARD} all but {len(over)} of {len(values(rows, 'scene'))} scenes stay below the lines"
        + (f": {', '.join(over)}." if over else ".")))
    section.plot(folder, front_figure(rows), "windows.png",
                 "Differences against run time; at the ends of a line its shortest and longest window. "
                 "Lines across: 1 mN, 3 mN, 10 µm.")
    section.table(as_table(rows), "All runs. Marked: beyond the lines with windows up to 16 ms.",
                  marked=lambda row: row["k"] <= STANDARD and (row["p95"] > 1 or row["p99"] > 3 or row["tip p95 (µm)"] > 10))
    section.table([{"scene": row["scene"], "why": row["refused"].split(": ", 1)[-1]} for row in where(refused, window=STANDARD)],
                  "Scenes that cannot have a window.")
    return [section]
