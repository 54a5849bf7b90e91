# SPDX-License-Identifier: MIT
"""Steering: a bevel needle drifts towards where its bevel looks. Spun at the right moments it meets a target.

Shows closed-loop control with a Client alone; acus.env has the same as an environment for learning.
"""

# %% A target 6 mm beside the needle's axis and 70 mm below the surface.
import numpy as np

import acus
from acus import rotation

TARGET = np.array([0.0, 0.006, -0.01])  # m, world
FEED = 1e-3  # m between two corrections
TURN = 1.0  # rad of a correction at most
TICKS = 25  # of the scene's 500 Hz for one: 20 mm/s

server = acus.Server(acus.find_scene("steering"), lockstep=True)
client = server.client()
needle = client.needles[0]
side, up = (rotation.rotate(needle.base_orientation, axis) for axis in ([0, 1, 0], [0, 0, 1]))

# %% What the bevel has to do: look to where the target lies beside the way ahead. Straight on, it spins all the time.


def turn_towards(target, tip, heading, spin):
    ahead = target - tip
    aside = ahead - (ahead @ heading) * heading
    if np.linalg.norm(aside) < 2e-4:
        return TURN
    error = (np.arctan2(aside @ up, aside @ side) - spin + np.pi) % (2 * np.pi) - np.pi
    return np.clip(error, -TURN, TURN)


# %% Push and correct until the target is passed.
depth = spin = 0.0
nearest, heading = np.inf, needle.axis
tip = client.step(1)[needle.name].tip_position
while (TARGET - tip) @ needle.axis > 0:
    depth, spin = depth + FEED, spin + turn_towards(TARGET, tip, heading, spin)
    client.pose(needle.name, needle.base_position + depth * needle.axis, needle.base_orientation, spin)
    before, tip = tip, client.step(TICKS)[needle.name].tip_position
    if np.linalg.norm(tip - before) > 1e-4:
        heading = (tip - before) / np.linalg.norm(tip - before)
    nearest = min(nearest, np.linalg.norm(TARGET - tip))
print(f"the tip came to {1e3 * nearest:.2f} mm from the target, {1e3 * np.hypot(*tip[:2]):.1f} mm beside the axis")

# %% The end.
client.close()
server.end()
