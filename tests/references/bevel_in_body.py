#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The arc along which a bevel steers its needle through an unbounded elastic body: the reference for models/unresolved/bevel.h.

The needle is a beam from its edge backwards. Each length of it displaces the body by Kelvin's solution, averaged over the
circumference, of the force that it bears there. Behind the edge, the middle of its section is between the edge and the
axis; where there is metal beside the cut, the body is displaced from the cut to that middle. The edge is on the cut, and
bears the cutting force along the cut. The cut is an arc, which the needle follows far from its edge; its curvature is
what is unknown. All is linear.

Prints the radius of the arc.

Usage: bevel_in_body.py [E_IN_KPA NU DIAMETER_IN_MM EI_IN_N_MM² FACE_IN_DEGREES CUTTING_FORCE_IN_N]
                        default: four needles
"""

import math
import sys
import unittest

import numpy as np

NEEDLES = [(100, 0.45, 1.0, 2945, 11, 0), (30, 0.40, 0.7, 707, 20, 0), (150, 0.45, 0.718, 2243, 17, 0),
           (30, 0.45, 1.0, 2945, 11, 0.6)]
FINEST = 0.25  # of the diameter: length of a beam
LONGEST = 9    # lengths within which the needle bends
RADII = [0.4425, 0.4788, 0.3815, 0.8149]  # m


def displacement(n, h, radius, E, nu):
    """m/N, n x n: of the places x = 0, h, 2 h, ... by a force spread over h around each of them."""
    def integral(u):
        return (3 - 4 * nu) * np.arcsinh(u / radius) + u / (2 * np.hypot(u, radius))

    apart = h * np.subtract.outer(np.arange(n), np.arange(n))
    shear = E / (2 * (1 + nu))
    return (integral(apart + h / 2) - integral(apart - h / 2)) / (16 * math.pi * shear * (1 - nu) * h)


def beams(n, h, EI):
    """Of Hermite's beams; deflection and slope of each node in turn."""
    one = EI / h**3 * np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                                [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]])
    stiffness = np.zeros((2 * n, 2 * n))
    for i in range(0, 2 * n - 2, 2):
        stiffness[i:i + 4, i:i + 4] += one
    return stiffness


def radius_of_arc(E, nu, d, EI, face, cutting_force=0, finest=FINEST):
    """m. E in kPa, d in mm, EI in N mm², face in degrees, cutting_force in N."""
    E, d, EI, face = 1e3 * E, 1e-3 * d, 1e-6 * EI, math.radians(face)
    bends = (4 * EI / E) ** 0.25
    h = finest * d
    n = int(LONGEST * bends / h)
    x = h * np.arange(n)
    middle = d / 2 * np.maximum(0, 1 - x * math.tan(face) / d)  # of the section, off the axis
    held = np.linalg.inv(displacement(n, h, d / 2, E, nu))      # N/m
    system = beams(n, h, EI)
    system[::2, ::2] += held
    by_bevel, by_arc = np.zeros(2 * n), np.zeros(2 * n)
    by_bevel[::2] = held @ middle
    by_bevel[1] = cutting_force * d / 2
    system[0, 1] += cutting_force  # the needle has a slope to the cut
    by_arc[::2] = held @ (-x * x / 2)
    by_arc[-1] = -EI
    from_bevel, from_arc = np.linalg.solve(system, np.stack([by_bevel, by_arc], axis=1)).T
    return from_arc[0] / (d / 2 - from_bevel[0])


class Arc(unittest.TestCase):
    def test_radii(self):
        for needle, radius in zip(NEEDLES, RADII):
            self.assertAlmostEqual(radius_of_arc(*needle) / radius, 1, delta=1e-3)

    def test_finer_beams_change_little(self):
        coarse, fine = (radius_of_arc(*NEEDLES[0], finest=finest) for finest in (2 * FINEST, FINEST))
        self.assertAlmostEqual(coarse / fine, 1, delta=3e-3)


if __name__ == "__main__":
    if "--test" in sys.argv:
        unittest.main(argv=sys.argv[:1])
    if any(word in sys.argv for word in ("-h", "--help")):
        sys.exit(__doc__)
    given = [float(word) for word in sys.argv[1:]]
    for needle in [given] if given else NEEDLES:
        force = needle[5] if len(needle) > 5 else 0
        print("E {:g} kPa, nu {:g}, needle of {:g} mm, EI {:g} N mm², face of {:g} degrees,".format(*needle),
              f"f_c {force:g} N: {radius_of_arc(*needle):.4f} m", flush=True)
