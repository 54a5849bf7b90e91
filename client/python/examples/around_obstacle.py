# SPDX-License-Identifier: MIT
"""Where a bevel needle has to go in, and when it has to turn, to meet a target behind an obstacle. Five minutes on two cores."""

# %% An obstacle of 5 mm lies half way: from nowhere in the entry region does a straight line lead past it.
import acus

target = (0, 0, -0.02)                                                              # m, world
entry_region = {"cylinder": {"from": [0, 0, 0.05], "to": [0, 0, 0.07], "radius": 0.004}}
obstacle = {"sphere": {"center": [0, 0, 0.02], "radius": 0.0025}}
plans = acus.plan("steering", target, entry_region, {"obstacle": obstacle}, cases=400)
print(plans)

# %% A picture; a scene and a trajectory for acus-server and acus-replay; a recording for acus-view.
plans.draw("plan.png")
plans[0].write("plan")
print(plans[0].run(recording="plan.acus").track.depth[-1])
