# SPDX-License-Identifier: MIT
"""A closed control loop at 1 kHz in real time: press on a tissue with a force of 0.3 N, and hold it.

Each turn waits for the newest states, and answers with a pose. How long a pose takes to come back in a state is the
delay of the loop; turns that the program or the machine missed are told, too. python3 control_loop.py [SECONDS]
"""

# %% The default scene at 1000 Hz, with a mesh that one core computes in a fraction of a tick.
import sys
import time

import numpy as np

import acus

WANTED = 0.3  # N, below the 1 N that punctures
GAIN = 0.02  # m/s for each newton that is missing
FASTEST = 0.05  # m/s
SECONDS = float(sys.argv[1]) if len(sys.argv) > 1 else 3.0

scene = acus.Scene.read(acus.find_scene("insertion_pullback"))
scene["tissue.mesh.box.cells"] = [5, 5, 5]
scene["needles[0].beams"] = 15
server = acus.Server(scene, rate=1000)
client = server.client()
needle = client.needles[0]

# %% The loop: speed in proportion to the force that is missing.
depth, forces, delays, turns = 0.0, [], [], 0
states = client.wait()
first, tick = states.tick, states.tick
while tick - first < SECONDS * client.hello.rate:
    force = states[needle.name]
    resistance = -force.base_force_in_base[0]
    speed = np.clip(GAIN * (WANTED - resistance), -FASTEST, FASTEST)
    depth += speed * (states.tick - tick) * client.time_step
    client.pose(needle.name, needle.base_position + depth * needle.axis)
    forces.append(resistance)
    if force.seq > 0:
        delays.append(time.monotonic() - force.echo)
    tick, turns = states.tick, turns + 1
    states = client.wait()

# %% How it went.
print(f"{turns} turns for {tick - first + 1} ticks, {client.lost_states} lost")
if delays:
    print(f"from a pose to the states that used it: median {1e3 * np.median(delays):.2f} ms, "
          f"99th percentile {1e3 * np.percentile(delays, 99):.2f} ms")
print(f"force in the last tenth: {np.mean(forces[-len(forces) // 10:]):.3f} N, wanted {WANTED} N")
client.close()
server.end()
