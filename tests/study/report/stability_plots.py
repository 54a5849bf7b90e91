# SPDX-License-Identifier: GPL-3.0-or-later
"""Which extreme scenes stay stable, from stability.csv (tests/study/studies/stability_criteria.h tells the measures)."""

import matplotlib.pyplot as plt
from matplotlib.patches import Patch
from page import Section
from tables import values, where

COLOURS = {"sound": "#009e73", "flagged": "#f0e442", "refused": "#56b4e9", "failed": "#d55e00"}
MEANINGS = {"sound": "sound", "flagged": "sound but for ticks that were flagged", "refused": "refused when loading",
            "failed": "failed"}


def grid_figure(rows):
    """A square per run: cases alone on the diagonal, pairs below it."""
    pairs = [r for r in rows if r["partner"]]
    paired = set(values(pairs, "case")) | set(values(pairs, "partner"))
    cases = [name for name in dict.fromkeys(values(rows, "case") + values(rows, "partner")) if name in paired]
    place = {name: i for i, name in enumerate(cases)}
    figure, axes = plt.subplots(figsize=(0.32 * len(cases) + 4, 0.32 * len(cases) + 3), layout="constrained")
    for row in rows:
        if row["case"] not in place:
            continue
        a, b = place[row["case"]], place[row["partner"] or row["case"]]
        axes.add_patch(plt.Rectangle((min(a, b) - 0.45, max(a, b) - 0.45), 0.9, 0.9, color=COLOURS[row["outcome"]]))
    axes.set_xticks(range(len(cases)), cases, rotation=90, fontsize=8)
    axes.set_yticks(range(len(cases)), cases, fontsize=8)
    axes.set_xlim(-0.6, len(cases) - 0.4)
    axes.set_ylim(len(cases) - 0.4, -0.6)
    for side in axes.spines.values():
        side.set_visible(False)
    axes.tick_params(length=0)
    axes.legend(handles=[Patch(color=COLOURS[o], label=MEANINGS[o]) for o in COLOURS], frameon=False, loc="upper right")
    return figure


def short(row):
    keys = {"outcome": "outcome", "ticks": "ticks", "flagged": "flagged", "energy_gain": "energy gain",
            "energy_rise": "rise at rest", "alternation": "alternation", "return": "return",
            "residual_N": "residual (N)", "largest_force_N": "largest force (N)", "ms_per_tick": "ms per tick",
            "why": "why"}
    return {"case": row["case"] + (f" + {row['partner']}" if row["partner"] else ""),
            **{name: row[key] for key, name in keys.items()}}


def sections(folder):
    rows = folder.read("stability.csv")
    if not rows:
        return []
    passed = len(where(rows, **{"pass": "yes"}))
    section = Section("Stability", (
        f"{len(rows)} runs of extreme scenes and of pairs of them, {passed} passed: numbers stay finite; the laws' "
        "residual is below its tolerance or the tick is flagged; no energy comes from nowhere, and at rest it falls; "
        "forces do not alternate from tick to tick; tissue returns after withdrawal. Shares are of the largest value "
        "in the run."))
    counts = {outcome: len(where(rows, outcome=outcome)) for outcome in COLOURS}
    section.table([{"": "runs", **counts}], "Outcomes.")
    section.plot(folder, grid_figure(rows), "stability.png",
                 "Cases alone on the diagonal, the nastiest in pairs beneath it.")
    failed = where(rows, outcome="failed")
    section.table([short(r) for r in failed], "Runs that failed.", marked=lambda row: True)
    section.table([short(r) for r in rows if not r["partner"]], "All cases alone.",
                  marked=lambda row: row["outcome"] == "failed")
    return [section]
