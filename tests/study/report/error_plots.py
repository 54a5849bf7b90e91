# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against run time, and which error dominates, from errors_SCENE.csv (the kinds of error:
tests/study/studies/error_settings.h)."""

import math

import matplotlib.pyplot as plt
import numpy as np
from page import Section
from tables import values, where

MEASURES = {"force": ("base force", "N", 1), "tip": ("tip", "mm", 1e3), "tissue": ("tissue nodes", "mm", 1e3)}
STATISTICS = {"p95": "95 %", "rms": "RMS", "max": "maximum"}  # of an error over the run
STANDARD = 1e-3  # s
RATES = {"1 kHz": 1e-3, "100 Hz": 10e-3, "30 Hz": 1 / 30}  # longest tick (s)
BUDGET = 0.8  # share of real time that a recommended setting may take
COLOURS = {"linear": "#e69f00", "warped": "#0072b2", "refined 2": "#009e73", "refined 3": "#56b4e9",
           "converged": "#999999", "exact": "#d55e00"}
COLOURS_OF_SCENES = ("#0072b2", "#e69f00", "#009e73")
MARKERS = ("o", "s", "^", "D")


def same(a, b):
    return math.isclose(a, b, rel_tol=1e-3)


def setting(row):
    return "converged" if row["knob"] == "time step" else row["setting"]


def worst_share(row):
    """The largest of the three errors, each as a share of the largest value in the reference."""
    return max(row[f"{m}_p95"] / row[f"{m}_size"] if row[f"{m}_size"] else 0 for m in MEASURES)


def is_reference(row):
    return worst_share(row) < 1e-12


def front(rows, error):
    """Rows of which no other one is both faster and closer, the fastest first."""
    best, least = [], math.inf
    for row in sorted(rows, key=lambda r: (r["run_time"], error(r))):
        if error(row) < least:
            best.append(row)
            least = error(row)
    return best


def recommendation(rows, longest):
    """The closest setting that runs in real time with ticks that are not longer."""
    fits = [r for r in rows if r["h"] <= longest * 1.001 and r["run_time"] <= BUDGET and not is_reference(r)]
    return min(fits, key=worst_share, default=None)


def ring_recommended(axes, rows, y):
    rates_at = {}
    for rate, longest in RATES.items():
        row = recommendation(rows, longest)
        if row is not None:
            rates_at.setdefault((row["run_time"], y(row)), []).append(rate)
    for place, rates in rates_at.items():
        axes.plot(*place, "o", markersize=14, markerfacecolor="none", markeredgecolor="black")
        axes.annotate(", ".join(rates), place, textcoords="offset points", xytext=(9, 7), fontsize=8)


def draw_front(axes, rows, groups, measure, label):
    """One line per group of rows over their time steps; the front in grey behind."""
    _, unit, scale = MEASURES[measure]

    def y(row):
        return scale * row[f"{measure}_p95"]

    best = front(rows, y)
    axes.plot([r["run_time"] for r in best], [y(r) for r in best], color="#cccccc", linewidth=6, label="Pareto front")
    for k, (name, members) in enumerate(groups(rows).items()):
        members = sorted(members, key=lambda r: r["h"])
        axes.plot([r["run_time"] for r in members], [y(r) for r in members], marker=MARKERS[k % len(MARKERS)],
                  color=COLOURS.get(name, f"C{k}"), label=label.format(name), markersize=4, linewidth=1)
        for row in members[:: max(len(members) - 1, 1)]:
            axes.annotate(f"{1e3 * row['h']:.3g} ms", (row["run_time"], y(row)), textcoords="offset points",
                          xytext=(3, -9), fontsize=7, color="#555555")
    ring_recommended(axes, rows, y)
    axes.axvline(1, color="#d55e00", linewidth=1)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylabel(f"error of the {MEASURES[measure][0]} ({unit})")


def by_rung(rows):
    return {name: [r for r in rows if setting(r) == name] for name in dict.fromkeys(map(setting, rows))}


def by_nodes(rows):
    return {f"{n:.0f}": where(rows, nodes=n) for n in values(rows, "nodes")}


def fronts_figure(rows, groups, label, measures):
    rows = [r for r in rows if not is_reference(r)]
    scenes = values(rows, "scene")
    figure, all_axes = plt.subplots(len(measures), len(scenes), figsize=(6.2 * len(scenes), 4 * len(measures) + 0.6),
                                    squeeze=False, sharex="col", layout="constrained")
    for column, scene in enumerate(scenes):
        for axes, measure in zip(all_axes[:, column], measures):
            draw_front(axes, where(rows, scene=scene), groups, measure, label)
        all_axes[0, column].set_title(scene)
        all_axes[0, column].legend(frameon=False, fontsize=7)
        all_axes[-1, column].set_xlabel("processor seconds per simulated second")
    return figure


def recommendations(rows, what):
    table = []
    for scene in values(rows, "scene"):
        for rate, longest in RATES.items():
            row = recommendation(where(rows, scene=scene), longest)
            if row is None:
                continue
            table.append({"scene": scene, "real time at": rate, "choice of": what,
                          "rung": setting(row) if what == "rung" else row["rung"], "nodes": row["nodes"],
                          "tick (ms)": 1e3 * row["h"], "ms per tick": row["ms_per_tick"],
                          "tick / calibration": row["calibrated"], "share of real time": row["run_time"],
                          **{f"{m} error ({u}, 95 %)": s * row[f"{m}_p95"] for m, (_, u, s) in MEASURES.items()}})
    return table


def reference_text(rows):
    """How good the reference is: what rung exact says of it, and whether it converged."""
    exact = where(rows, setting="exact", error="solver")
    open_ticks = sum(row["not_converged"] for row in where(rows, knob="time step"))
    text = f"References are of rung refined, iterated to 1e-12 m; {open_ticks:.0f} of their ticks ended above that. "
    if exact:
        apart = "; ".join(f"{row['scene']} {row['force_p95']:.0e} N, at most {row['force_max']:.0e} N" for row in exact)
        text += (f"Rung exact, Newton to 1e-12 m, with ticks of {1e3 * exact[0]['h']:.0f} ms differs from them in 95 of "
                 f"100 base forces by less than: {apart}.")
    return text


def run_time_section(folder, rows):
    section = Section("Error against run time", (
        "Every line is one way to solve, over time steps. An error is the difference from the converged reference over "
        "the whole motion, below which 95 of 100 values are; root mean squares and maxima stand in "
        "<a href=\"errors.csv\">errors.csv</a>. Those of forces are mostly punctures that happen a tick earlier "
        "or later. Left of the red line a setting runs in real "
        f"time on one core. Rings: the smallest error of those that take at most {BUDGET:.0%} of real time with ticks "
        "of at most 1 ms, 10 ms and 33 ms."))
    section.text(reference_text(rows))
    on_one_mesh = where(rows, error="total", knob=("rung", "time step"))
    section.plot(folder, fronts_figure(on_one_mesh, by_rung, "{}", ["force"]), "pareto.png",
                 "The scene's own mesh, beams and spacing; error of solver and time step together, against the "
                 "shortest time step, converged.")
    section.plot(folder, fronts_figure(on_one_mesh, by_rung, "{}", ["tip", "tissue"]), "pareto_shapes.png",
                 "The same for tips and tissue.")
    over_meshes = where(rows, error="overall")
    if not all(map(is_reference, over_meshes)):
        section.plot(folder, fronts_figure(over_meshes, by_nodes, "{} nodes", MEASURES), "pareto_meshes.png",
                     "Rung warped on four meshes; error of mesh, time step and solver together, against the finest "
                     "mesh with a tick of 1 ms.")
    table = recommendations(on_one_mesh, "rung") + recommendations(over_meshes, "mesh")
    folder.write("recommendations.csv", table)
    section.table(table, "The ringed settings: with the mesh given, and with the mesh to choose.")
    return section


def own_value(rows, knob, standard):
    """The row of a knob's study in which the scene is as it stands."""
    column = {"beams": "beams", "spacing": "spacing", "cells": "nodes"}[knob]
    return next((r for r in where(rows, knob=knob, error="discretisation") if same(r[column], standard[column])), None)


def shares(rows):
    """One row per scene and kind of error, with the scene as it stands and a tick of 1 ms."""
    table = []
    for scene in values(rows, "scene"):
        mine = [r for r in where(rows, scene=scene) if same(r["h"], STANDARD)]
        standard = next(iter(where(mine, knob="rung", setting="warped", error="solver")), None)
        if standard is None:
            continue  # of a study that was stopped
        kinds = {"solver": standard, "time step": next(iter(where(mine, knob="time step")), None),
                 "gauss_seidel 1e-4 N": next(iter(where(mine, setting="0.0001 N", error="laws")), None)}
        kinds |= {knob: own_value(mine, knob, standard) for knob in ("spacing", "beams", "cells")}
        for kind, row in kinds.items():
            if row is not None:
                table.append({"scene": scene, "error": {"cells": "mesh"}.get(kind, kind),
                              **{f"{m} {name} ({u})": s * row[f"{m}_{key}"] for key, name in STATISTICS.items()
                                 for m, (_, u, s) in MEASURES.items()}})
    return table


def shares_figure(table):
    scenes, kinds = values(table, "scene"), values(table, "error")
    keys = list(table[0])[2:2 + len(MEASURES)]
    figure, all_axes = plt.subplots(1, len(keys), figsize=(6 * len(keys), 4), layout="constrained")
    for axes, key in zip(all_axes, keys):
        for k, scene in enumerate(scenes):
            found = [next((r[key] for r in where(table, scene=scene, error=kind)), np.nan) for kind in kinds]
            axes.bar(np.arange(len(kinds)) + 0.8 * k / len(scenes), np.maximum(found, 1e-9), 0.8 / len(scenes),
                     label=scene)
        axes.set_xticks(np.arange(len(kinds)) + 0.3, kinds, rotation=25)
        axes.set_yscale("log")
        axes.set_ylim(1e-7, 30 * axes.get_ylim()[1])
        axes.set_title(key)
    all_axes[0].legend(frameon=False, fontsize=8)
    return figure


def shares_section(folder, rows):
    section = Section("Which error dominates", (
        "Each scene as it stands, at 1,000 ticks a second. <i>solver</i>: rung warped against the converged answer of "
        "the same tick. <i>time step</i>: the converged answer against that of the shortest tick. <i>gauss_seidel</i>: "
        "against the direct solution of the laws. <i>spacing, beams, mesh</i>: against the finest one of the study."))
    table = shares(rows)
    folder.write("dominance.csv", table)
    if table:
        section.plot(folder, shares_figure(table), "dominance.png",
                     "Errors by their cause: 95 of 100 values are smaller.")
    section.table(table, "The same with root mean squares and maxima. Maxima of forces are punctures a tick apart.")
    return section


def orders(rows):
    table = []
    for scene in values(rows, "scene"):
        steps = sorted(where(rows, scene=scene, knob="time step"), key=lambda r: r["h"])
        for a, b in zip(steps[1:], steps[2:]):
            shortest = steps[0]["h"]
            if not all(row[f"{m}_p95"] > 0 for row in (a, b) for m in MEASURES):
                continue
            ratio = math.log((b["h"] - shortest) / (a["h"] - shortest))
            table.append({"scene": scene, "from (ms)": 1e3 * a["h"], "to (ms)": 1e3 * b["h"],
                          **{m: math.log(b[f"{m}_p95"] / a[f"{m}_p95"]) / ratio for m in MEASURES}})
    return table


def time_step_section(folder, rows):
    section = Section("Time step", (
        "Converged solutions against that of the shortest tick h0. The order is that of the error in h - h0, one for "
        "backward Euler. Motions are rounded over 10 ms, the same for every tick, so that inertial forces of a base "
        "whose speed jumps do not grow with 1/h."))
    figure, all_axes = plt.subplots(1, len(MEASURES), figsize=(6 * len(MEASURES), 4.2), layout="constrained")
    for axes, (measure, (name, unit, scale)) in zip(all_axes, MEASURES.items()):
        for scene in values(rows, "scene"):
            steps = [r for r in where(rows, scene=scene, knob="time step") if not is_reference(r)]
            axes.plot([1e3 * r["h"] for r in steps], [scale * r[f"{measure}_p95"] for r in steps], "o-", label=scene)
        low, high = axes.get_xlim()
        middle = np.array([max(low, 0.3), high])
        axes.plot(middle, middle / middle[-1] * axes.get_ylim()[1], ":", color="#555555", label="order one")
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("h (ms)")
        axes.set_ylabel(f"error of the {name} ({unit})")
    all_axes[0].legend(frameon=False, fontsize=8)
    section.plot(folder, figure, "time_step.png", "Error of the time step alone.")
    table = orders(rows)
    folder.write("orders.csv", table)
    section.table(table, "Observed orders.")
    return section


def laws_section(folder, rows):
    section = Section("Solver of the laws", (
        "Gauss–Seidel against the direct solution, at the same rung and a tick of 1 ms: what a tolerance leaves, and "
        "what a limit of sweeps leaves. Bilateral rows are eliminated before either solver begins."))
    figure, all_axes = plt.subplots(1, 2, figsize=(13, 4.2), layout="constrained")
    for axes, knob, key in ((all_axes[0], "gauss_seidel tolerance", "tolerance"),
                            (all_axes[1], "gauss_seidel steps", "max_steps")):
        for scene in values(rows, "scene"):
            found = where(rows, scene=scene, knob=knob, error="laws")
            for error, name, style in (("force_p95", "95 %", "o-"), ("force_max", "maximum", "o:")):
                axes.plot([r[key] for r in found], [max(r[error], 1e-12) for r in found], style,
                          color=COLOURS_OF_SCENES[values(rows, "scene").index(scene)], label=f"{scene}, {name}")
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_ylabel("error of the base force (N)")
    all_axes[0].set_xlabel("laws.tolerance (N)")
    all_axes[1].set_xlabel("laws.max_steps")
    all_axes[0].legend(frameon=False, fontsize=8)
    section.plot(folder, figure, "laws.png", "Forces depend on the tolerance as far as it allows, not more.")
    return section


def knobs_section(folder, rows):
    section = Section("Beams, spacing, mesh", (
        "Each against its finest value, all else as in the scene, rung warped, 1 ms. The mesh of the inclusion is a "
        "file with two regions; it is not refined."))
    knobs = {"beams": "beams", "spacing": "spacing", "cells": "nodes"}
    figure, all_axes = plt.subplots(len(MEASURES), len(knobs), figsize=(17, 10), sharex="col", layout="constrained")
    for column, (knob, key) in enumerate(knobs.items()):
        for axes, (measure, (name, unit, scale)) in zip(all_axes[:, column], MEASURES.items()):
            for scene in values(rows, "scene"):
                found = [r for r in where(rows, scene=scene, knob=knob, error="discretisation") if not is_reference(r)]
                axes.plot([r[key] for r in found], [scale * r[f"{measure}_p95"] for r in found], "o-", label=scene)
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_ylabel(f"{name} ({unit}, 95 %)")
        all_axes[-1, column].set_xlabel({"beams": "beams of the needle", "spacing": "constraint spacing (m)",
                                         "cells": "nodes of the mesh"}[knob])
    all_axes[0, 0].legend(frameon=False, fontsize=8)
    section.plot(folder, figure, "discretisation.png", "Errors of discretisation.")
    return section


def sections(folder):
    rows = folder.read_all("errors_*.csv")
    folder.write("errors.csv", rows)
    if not rows:
        return []
    makers = (run_time_section, shares_section, time_step_section, laws_section, knobs_section)
    return [make(folder, rows) for make in makers]
