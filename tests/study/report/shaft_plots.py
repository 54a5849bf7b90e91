# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether surfaces bear shafts beside their paths, from shafts.csv (tests/study/studies/shafts.h)."""

import matplotlib.pyplot as plt
from page import Section

MOST = 1.0  # mm


def unheld_figure(rows):
    figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
    for sweep, colour, meaning in ((0, "#0072b2", "pushed"), (1, "#d55e00", "pushed, then swept")):
        some = [r for r in rows if (r["sweep_mm"] > 0) == bool(sweep)]
        axes.scatter([r["diameter_mm"] for r in some], [r["unheld_mm"] for r in some], color=colour, s=22,
                     label=f"{meaning} ({len(some)})")
    axes.axhline(MOST, color="0.6", linewidth=1)
    axes.set_xlabel("needle's diameter (mm)")
    axes.set_ylabel("most shaft that nothing bears (mm)")
    axes.legend(frameon=False, loc="lower left", bbox_to_anchor=(0, 1), fontsize=9)
    return figure


def sections(folder):
    rows = folder.read("shafts.csv")
    if not rows:
        return []
    over = [r for r in rows if r["unheld_mm"] > MOST]
    lying = [r for r in rows if r["borne_ticks"] > 0]
    section = Section("Shafts", (
        f"{len(rows)} thin needles pushed onto random places, every other one then swept sideways. Surfaces bore the "
        f"shafts of {len(lying)}. In {len(over)} some shaft was over 1 mm deep in the tissue with nothing to bear it."))
    section.plot(folder, unheld_figure(rows), "shafts.png", "The most unheld length of each, by diameter.")
    section.table(over, "Those with more than 1 mm.")
    return [section]
