# SPDX-License-Identifier: MIT
"""Where a bevel needle comes to in gelatin that nobody knows exactly: 1,000 insertions on all cores, and two pictures."""

# %% What is uncertain, and how far.
import acus
from acus import study

gelatin = "tissue.regions[gelatin]."
uncertain = {gelatin + "material.young_modulus": study.LogUniform(40e3, 160e3),  # Pa
             gelatin + "interaction.friction_dynamic": (0.05, 0.19),
             "needles[0].point_offset": study.Normal(1, 0.1),  # of the bevel's point, over the needle's radius
             "motion.tilt": study.Normal(0, 0.01), "motion.azimuth": (0, 3.14159)}  # rad, of the hand

# %% A second run finds all rows in studies/steering_arc.
done = acus.Study("steering_arc", acus.Insertion(depth=0.1, speed=0.05), study.sobol(uncertain, 1000)).run()
done.draw_spread("spread.png")
done.draw("sensitivity.png")
