# SPDX-License-Identifier: GPL-3.0-or-later
"""What depends on the mesh, and what mends it: locking.csv (server/study/locking.h) and mesh_dependence.csv
(server/study/mesh_dependence.h)."""

import matplotlib.pyplot as plt
from page import Section
from tables import values, where

STYLES = {"linear": "o-", "nodal_pressure": "s--"}
LOCKING = {"needle": "needle pushed sideways: displacement", "vortex": "swirling load: displacement",
           "bending": "bent bar: work of the load"}


def locking_figure(rows):
    meshes = values(rows, "mesh")
    figure, all_axes = plt.subplots(len(meshes), len(LOCKING), figsize=(6 * len(LOCKING), 4 * len(meshes)),
                                    layout="constrained", squeeze=False, sharey="col")
    for line, mesh in enumerate(meshes):
        for axes, (measure, title) in zip(all_axes[line], LOCKING.items()):
            for element in values(rows, "element"):
                for k, nu in enumerate(values(rows, "poisson_ratio")):
                    found = where(rows, mesh=mesh, measure=measure, element=element, poisson_ratio=nu)
                    axes.plot([r["cells"] for r in found], [100 * (r["error"] or 0) for r in found], STYLES[element],
                              color=f"C{k}", label=f"{element}, nu = {nu:g}")
            axes.axhline(0, color="#999999", linewidth=1)
            axes.set_title(f"{title}, {mesh} mesh", fontsize=10)
            axes.set_xlabel("cells along an edge")
            axes.set_ylabel("error (%)")
    all_axes[0, 0].legend(frameon=False, fontsize=7)
    return figure


def locking_table(rows):
    """The error in per cent of every mesh and element, one column per Poisson's ratio."""
    table = []
    for measure in LOCKING:
        for mesh in values(rows, "mesh"):
            for element in values(rows, "element"):
                for cells in values(rows, "cells"):
                    found = where(rows, measure=measure, mesh=mesh, element=element, cells=cells)
                    table += [{"measure": measure, "mesh": mesh, "element": element, "cells": int(cells),
                               "nodes": int(found[0]["nodes"]), "factor entries": int(found[0]["factor_entries"]),
                               **{f"nu = {r['poisson_ratio']:g} (%)": 100 * (r["error"] or 0) for r in found}}] if found else []
    return table


def locking_section(folder, rows):
    section = Section("Locking", (
        "Linear tetrahedra grow too stiff as Poisson's ratio nears 0.5; <code>tissue.element: nodal_pressure</code> "
        "averages volume changes at the nodes. Errors against closed forms, of the needle against the finest mesh. The "
        "regular mesh of boxes locks less than meshes of organs do."))
    section.plot(folder, locking_figure(rows), "locking.png", "Error over four meshes and four Poisson's ratios.")
    section.table(locking_table(rows), "The same as numbers.")
    return section


def sections(folder):
    rows = folder.read("locking.csv")
    return [locking_section(folder, rows)] if rows else []
