# SPDX-License-Identifier: MIT
"""Twenty seeds by six needles into a prostate that each needle moves: aimed straight, and in the order and with the
corrections of a plan. Three minutes on two cores."""

# %% Targets on the needles' lines, m, in the world as the tissue lies at rest.
import numpy as np

import acus

scene = acus.Scene.read(acus.find_scene("brachytherapy"))
depths = {"needle 1": [9, 1, -10], "needle 2": [3, -2, -10], "needle 3": [13, 9, 0, -12],  # z, mm
          "needle 4": [11, 7, 2], "needle 5": [-1, -6, -11], "needle 6": [10, 0, -8, -15]}
seeds = {name: [(*scene[f"needles[{name}].base.position"][:2], 1e-3 * z) for z in each] for name, each in depths.items()}

# %% Orders are tried, what the seeds missed corrects the needles; a scene and a trajectory for acus-server and acus-replay.
plan = acus.plan.implant(scene, seeds, orders=12)
print(f"straight: {1e3 * plan.straight.mean():.2f} mm, planned: {1e3 * plan.errors.mean():.2f} mm; order: {', '.join(plan.order)}")
print(f"stiffness and friction uncertain: straight {1e3 * np.mean(plan.straight_samples):.2f} mm, planned {1e3 * np.mean(plan.samples):.2f} mm")
plan.write("implant")
