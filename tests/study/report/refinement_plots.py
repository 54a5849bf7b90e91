# SPDX-License-Identifier: GPL-3.0-or-later
"""What depends on the mesh, and what mends it: locking.csv (tests/study/studies/locking.h) and mesh_dependence.csv
(tests/study/studies/mesh_dependence.h)."""

import matplotlib.pyplot as plt
from page import Section
from tables import values, where

GOAL = 5  # per cent
STYLES = {"linear": "o-", "nodal_pressure": "s--"}
MESH_MEASURES = {"indentation": ("indentation", "mm", 1e3), "press_force": ("force at 0.3 mm", "N", 1),
                 "base_force": ("steady base force", "N", 1), "base_peak": ("peak base force", "N", 1),
                 "axial_stiffness": ("axial stiffness", "N/m", 1), "lateral_stiffness": ("lateral stiffness", "N/m", 1),
                 "dragged_force": ("base force, skin dragged along", "N", 1),
                 "dragged_depth": ("depth, skin dragged along", "mm", 1e3),
                 "steering_radius": ("steering radius", "m", 1)}
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
                    if found:
                        table.append({"measure": measure, "mesh": mesh, "element": element, "cells": cells,
                                      "nodes": found[0]["nodes"], "factor entries": found[0]["factor_entries"],
                                      **{f"nu = {r['poisson_ratio']:g} (%)": 100 * (r["error"] or 0) for r in found}})
    return table


def locking_section(folder, rows):
    section = Section("Locking", (
        "Linear tetrahedra grow too stiff as Poisson's ratio nears 0.5; <code>tissue.element: nodal_pressure</code> "
        "averages volume changes at the nodes. Errors against closed forms, of the needle against the finest mesh. The "
        "regular mesh of boxes locks less than meshes of organs do."))
    section.plot(folder, locking_figure(rows), "locking.png", "Error over four meshes and four Poisson's ratios.")
    section.table(locking_table(rows), "The same as numbers.")
    return section


def draw_measure(axes, rows, measure, scale):
    for k, added in enumerate(values(rows, "added")):
        for element in values(rows, "element"):
            found = where(rows, added=added, element=element)
            if found and isinstance(found[0][measure], float):
                axes.plot([1e3 * r["element_size"] for r in found], [scale * r[measure] for r in found],
                          STYLES[element], color=f"C{k}", label=f"{added}, {element}")
    axes.invert_xaxis()
    axes.set_ylim(0, 1.1 * axes.get_ylim()[1])


def mesh_figure(rows):
    """All measures for one Poisson's ratio."""
    across = 4
    down = -(-len(MESH_MEASURES) // across)
    figure, all_axes = plt.subplots(down, across, figsize=(5 * across, 4 * down), layout="constrained")
    for axes in all_axes.flat[len(MESH_MEASURES):]:
        axes.set_axis_off()
    for axes, (measure, (name, unit, scale)) in zip(all_axes.flat, MESH_MEASURES.items()):
        draw_measure(axes, rows, measure, scale)
        axes.set_title(f"{name} ({unit})", fontsize=10)
        axes.set_xlabel("edge of a cell (mm)")
    all_axes.flat[len(MESH_MEASURES)].legend(*all_axes.flat[0].get_legend_handles_labels(), frameon=False)
    return figure


def deviation(row, finest, measure):
    """From the finest mesh, in per cent; empty where it was not measured."""
    if not isinstance(row[measure], float) or not finest[measure]:
        return ""
    return 100 * (row[measure] / finest[measure] - 1)


def mesh_table(rows):
    table = []
    for nu in values(rows, "poisson_ratio"):
        for element in values(rows, "element"):
            for added in values(rows, "added"):
                found = sorted(where(rows, poisson_ratio=nu, element=element, added=added), key=lambda r: -r["cells"])
                table += [{"added": added, "element": element, "nu": nu, "cell (mm)": 1e3 * row["element_size"],
                           **{f"{name} (%)": deviation(row, found[0], m) for m, (name, _, _) in MESH_MEASURES.items()}}
                          for row in found[1:]]
    return table


def is_close(percent):
    return percent == "" or abs(percent) <= GOAL


def verdicts(rows):
    """Whether the coarsest mesh tells what the finest one does."""
    table = []
    for nu in values(rows, "poisson_ratio"):
        for element in values(rows, "element"):
            for added in values(rows, "added"):
                found = sorted(where(rows, poisson_ratio=nu, element=element, added=added), key=lambda r: r["cells"])
                if not found:
                    continue
                apart = {m: deviation(found[0], found[-1], m) for m in ("base_force", "base_peak", "steering_radius")}
                table.append({"added": added, "element": element, "nu": nu,
                              "coarser by": found[-1]["cells"] / found[0]["cells"],
                              **{f"{MESH_MEASURES[m][0]} (%)": value for m, value in apart.items()},
                              f"within {GOAL} %": "yes" if all(map(is_close, apart.values())) else "no"})
    return table


def mesh_section(folder, rows):
    section = Section("Point forces and the mesh", (
        "A needle acts on points, and the larger the elements are, the stiffer they answer. "
        "<code>tissue.local_compliance</code> adds what they cannot give way (<i>all</i>; <i>none</i> is the mesh alone)."))
    for nu in values(rows, "poisson_ratio"):
        section.plot(folder, mesh_figure(where(rows, poisson_ratio=nu)), f"mesh_dependence_{nu:g}.png",
                     f"What a needle feels, over meshes; nu = {nu:g}.")
    section.table(verdicts(rows), "The coarsest mesh against the finest one.")
    section.table(mesh_table(rows), "Difference from the finest mesh of the same kind, in per cent.")
    return section


def refinement(locking, mesh):
    """Both tables as one: a row per measured value, with its difference from the reference or the finest mesh."""
    rows = [{"study": "locking", "measure": r["measure"], "mesh": r["mesh"], "element": r["element"], "added": "",
             "poisson_ratio": r["poisson_ratio"], "cells": int(r["cells"]), "value": r["value"],
             "reference": r["reference"],
             "difference_percent": 100 * r["error"] if isinstance(r["error"], float) else ""} for r in locking]
    for row in mesh:
        same = where(mesh, poisson_ratio=row["poisson_ratio"], element=row["element"], added=row["added"])
        finest = max(same, key=lambda r: r["cells"])
        rows += [{"study": "mesh dependence", "measure": measure, "mesh": "regular", "element": row["element"],
                  "added": row["added"], "poisson_ratio": row["poisson_ratio"], "cells": int(row["cells"]),
                  "value": row[measure], "reference": finest[measure],
                  "difference_percent": deviation(row, finest, measure)} for measure in MESH_MEASURES]
    return rows


def sections(folder):
    folder.write("refinement.csv", refinement(folder.read("locking.csv"), folder.read("mesh_dependence.csv")))
    made = []
    for name, make in (("locking.csv", locking_section), ("mesh_dependence.csv", mesh_section)):
        rows = folder.read(name)
        if rows:
            made.append(make(folder, rows))
    return made
