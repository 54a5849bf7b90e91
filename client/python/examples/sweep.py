# SPDX-License-Identifier: MIT
"""A parameter study on all cores: how far a tissue of some stiffness gives way before a needle punctures it.

A second run finds the rows of the first in the folder and does what is missing.
"""

# %% The scene, coarser than it stands, and what is varied.
import acus


def study(folder):
    scene = acus.Scene.read(acus.find_scene("insertion_pullback"))
    scene["rate"] = 200
    scene["tissue.mesh.box.cells"] = [6, 6, 6]
    return acus.Study(scene, acus.Insertion(depth=0.04, speed=0.05),
                      {"tissue.regions[phantom].material.young_modulus": [5e3, 10e3, 20e3],  # Pa
                       "tissue.regions[phantom].interaction.puncture_force": [0.5, 1.0]},  # N
                      ["puncture_travel", "end_force"], folder=folder)


# %% As many at once as there are cores.
def main():
    done = study("sweep").run()
    print(f"{'E (kPa)':>8}{'puncture (N)':>14}{'gave way (mm)':>15}{'at the end (N)':>16}")
    for row in done.rows:
        stiffness, puncture = (row[name] for name in done.parameters)
        print(f"{stiffness / 1e3:8.0f}{puncture:14.1f}{1e3 * row['puncture_travel']:15.1f}{row['end_force']:16.2f}")


if __name__ == "__main__":
    main()
