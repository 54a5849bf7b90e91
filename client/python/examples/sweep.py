# SPDX-License-Identifier: MIT
"""A parameter sweep on all cores: how far a tissue of some stiffness gives way before a needle punctures it.

Each combination is a scene of its own, made in Python and run by a server of its own.
"""

# %% What is varied, and what one insertion tells.
import itertools
import multiprocessing

import numpy as np

import acus

STIFFNESS = (5e3, 10e3, 20e3)  # Pa
PUNCTURE = (0.5, 1.0)  # N
SPEED = 0.05  # m/s
WAY = 0.04  # m


def insert(combination):
    """How far the base went from contact to puncture (m), and the axial resistance at the end (N)."""
    stiffness, puncture = combination
    scene = acus.Scene.read(acus.find_scene("insertion_pullback"))
    scene["rate"] = 200
    scene["tissue.mesh.box.cells"] = [6, 6, 6]
    scene["tissue.regions[phantom].material.young_modulus"] = stiffness
    scene["tissue.regions[phantom].interaction.puncture_force"] = puncture
    with acus.Server(scene.check(), lockstep=True) as server, server.client() as client:
        needle, states = client.needles[0], []
        for tick in range(1, round(WAY / SPEED / client.time_step)):
            client.pose(needle.name, needle.base_position + tick * SPEED * client.time_step * needle.axis)
            states.append(client.step(1))
    run = acus.Run.of_states(states)
    track = run[needle.name]
    contact, puncture = (next(event.tick for event in run.events if event.kind == kind)
                         for kind in ("contact", "puncture"))
    way = track.travel[np.searchsorted(track.tick, [contact, puncture])]
    return way[1] - way[0], track.axial_resistance[-1]


# %% As many at once as there are cores.
def main():
    combinations = list(itertools.product(STIFFNESS, PUNCTURE))
    with multiprocessing.Pool() as pool:
        results = pool.map(insert, combinations, chunksize=1)
    print(f"{'E (kPa)':>8}{'puncture (N)':>14}{'gave way (mm)':>15}{'at the end (N)':>16}")
    for (stiffness, puncture), (way, force) in zip(combinations, results):
        print(f"{stiffness / 1e3:8.0f}{puncture:14.1f}{1e3 * way:15.1f}{force:16.2f}")


if __name__ == "__main__":
    main()
