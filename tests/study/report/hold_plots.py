# SPDX-License-Identifier: GPL-3.0-or-later
"""What hands feel that stop at any moment, from holds.csv (tests/study/studies/study.h)."""

import matplotlib.pyplot as plt
from page import Section
from tables import values, where

FELT = 0.05  # N


def jump_figure(rows, scenes):
    figure, axes = plt.subplots(figsize=(8, 0.4 * len(scenes) + 1.2), layout="constrained")
    for i, scene in enumerate(scenes):
        jumps = [max(jump, 1e-6) for jump in values(where(rows, scene=scene), "jump_N")]
        axes.scatter(jumps, [i] * len(jumps), color="#0072b2", s=12, alpha=0.5)
    axes.axvline(FELT, color="#d55e00", linewidth=1)
    axes.set_xscale("log")
    axes.set_yticks(range(len(scenes)), scenes)
    axes.set_xlabel("largest jump of the base force without an event (N)")
    return figure


def sections(folder):
    rows = folder.read("holds.csv")
    if not rows:
        return []
    scenes = sorted({row["scene"] for row in rows})
    felt = [row for row in rows if row["jump_N"] > FELT]
    section = Section("Holds", (
        f"{len(rows)} times the bases stop at a random moment of a scene's motion at 1 kHz and rest for 0.3 s. "
        f"{len(felt)} forces jumped by more than {FELT} N from one tick to the next without an event of their needle."))
    section.plot(folder, jump_figure(rows, scenes), "holds.png", "The largest jump after each stop; the line is 0.05 N.")
    section.table(sorted(rows, key=lambda row: -row["jump_N"])[:10], "The ten largest.",
                  marked=lambda row: row["jump_N"] > FELT)
    return [section]
