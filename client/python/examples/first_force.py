# SPDX-License-Identifier: MIT
"""The force on a needle as it goes into a block, without a server: eight lines. The picture goes to force.png."""

import matplotlib.pyplot as plt
from acus import engine
model = engine.load("insertion_pullback")
state, needle = model.start(), model.needles[0]
push = [needle.base_position + 2e-5 * tick * needle.axis for tick in range(3000)]  # m, world: 20 mm/s at 1 kHz
felt = [engine.step(model, state, {"needle": (place, needle.base_orientation)})["needle"] for place in push]
plt.plot([each.base_force @ -needle.axis for each in felt])  # N over ms
plt.savefig("force.png")
