# SPDX-License-Identifier: MIT
"""Closed loop: a plan for tissue that turns out to be a fifth as stiff, as it is, and corrected by measured tips on the way.

python3 closed_loop.py [--real-time]: the server in lockstep, or at its own rate, with the corrections beside it.
"""

# %% What is believed, for the plan and for predictions: few nodes, long ticks. What is true: scenes/steering.yaml, but softer.
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import acus
from acus.tissue_points import TissuePoints

REAL_TIME = "--real-time" in sys.argv
NOISE = 0.2e-3  # m, of measured tips and targets
TARGET = (0.0, 0.008, -0.014)  # m, world
true = acus.Scene.read(acus.find_scene("steering"))
believed = true.copy()
true["tissue.regions[gel].material.young_modulus"] /= 5
believed["rate"] = 100
believed["tissue.mesh.box.cells"] = [5, 5, 8]
believed["needles[0].beams"] = 30

# %% A plan with a flip, through a template: directions stay.
entry_region = {"cylinder": {"from": [0, 0, 0.05], "to": [0, 0, 0.07], "radius": 0.003}}
plans = acus.plan(believed, TARGET, entry_region, tilt=0, uncertain={}, cases=60, progress=False)
plan = next(each for each in plans if each.motion.flips)
print(f"plan: {plan}")

# %% One insertion. Places to go to come in strides; while one is commanded, the next is found.


def insert(next_stride):
    random, measured, count = np.random.default_rng(1), [], 0
    with acus.Server(plan.place(true), lockstep=not REAL_TIME) as server, server.client() as client, ThreadPoolExecutor(1) as other:
        client.subscribe("tissue")
        needle, target = client.needles[0], TissuePoints(client.describe(), [TARGET])
        ticks = round(client.hello.rate / believed["rate"])
        while client.tissue is None:
            states = client.wait() if REAL_TIME else client.step(1)
        tick, coming = states.tick, other.submit(next_stride, [])
        while places := coming.result():
            coming, measured = other.submit(next_stride, measured), []
            for advance, spin in places:
                client.pose(needle, needle.base_position + advance * needle.axis, needle.base_orientation, spin)
                count, tick = count + 1, max(tick, states.tick) + ticks
                while states.tick < tick:
                    states = client.wait() if REAL_TIME else client.step(ticks)
                seen = [states[needle.name].tip_position, *target.at(client.tissue.positions)]
                measured.append((count, *(each + random.normal(scale=NOISE, size=3) for each in seen)))
        return 1e3 * np.linalg.norm(target.at(client.tissue.positions)[0] - states[needle.name].tip_position)


# %% As planned, and corrected.
motion = plan.motion
model = acus.engine.load(believed)
strides = iter([motion.places(acus.study.World(model, bodies=motion.bodies(model)))])
print(f"as planned: {insert(lambda measured: next(strides, [])):.2f} mm from the target")
steering = acus.plan.Steering(believed, TARGET, motion)
print(f"corrected: {insert(steering.next):.2f} mm from the target")
