# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether tissue notices needles that go in anywhere, from entries.csv (tests/study/studies/entries.h)."""

import matplotlib.pyplot as plt
from page import Section
from tables import values, where

COLOURS = {"punctured": "#009e73", "early": "#f0e442", "pressed": "#56b4e9", "found": "#cc79a7", "ghost": "#d55e00"}
MEANINGS = {"punctured": "punctured at f_p", "early": "punctured below 0.98 f_p, where elements were pressed flat",
            "pressed": "never punctured: slid off, or pushed the tissue ahead",
            "found": "found inside beside its path, which went on to it", "ghost": "ghost"}


def verdict_figure(rows):
    figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
    for verdict, colour in COLOURS.items():
        some = where(rows, verdict=verdict)
        axes.scatter(values(some, "ratio"), values(some, "tilt_deg"), color=colour, s=22,
                     label=f"{MEANINGS[verdict]} ({len(some)})")
    axes.set_xscale("log")
    axes.set_xlabel("puncture force over E a² (-)")
    axes.set_ylabel("tilt against the surface's normal (degrees)")
    axes.legend(frameon=False, loc="lower left", bbox_to_anchor=(0, 1), fontsize=9)
    return figure


def sections(folder):
    rows = folder.read("entries.csv")
    if not rows:
        return []
    ghosts = where(rows, verdict="ghost")
    section = Section("Entries", (
        f"{len(rows)} needles pushed onto random places of blocks and meshes, tilted, slow and fast, on rungs linear, "
        f"warped, refined and exact. {len(ghosts)} were ghosts: deeper than 1 mm in the tissue without path or contact."))
    section.plot(folder, verdict_figure(rows), "entries.png",
                 "Each needle by its puncture force, over what turns an element inside out at a point, and its tilt.")
    flat = [r for r in rows if r["support"] == 1]
    counts = [{"entries": name, **{v: len(where(some, verdict=v)) for v in COLOURS}}
              for name, some in (("all", rows), ("no edge nearer than the dimple", flat))]
    section.table(counts, "Outcomes.")
    section.table(ghosts, "Ghosts.", marked=lambda row: True)
    return [section]
