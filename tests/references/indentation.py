#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A blunt needle pressed onto soft tissue that it does not puncture, solved by CalculiX (Debian: calculix-ccx): the
reference for the force on the surface over the depth of the dimple.

The tissue: neo-Hookean, E = 10 kPa, nu = 0.45, a cylinder of 60 mm radius and height, held at its side and bottom. The
needle: rigid, round, flat at its end, its edge rounded by 0.3 of its radius; no friction, at its side neither, on which
the tissue that it draws down comes to lie. Axisymmetric bilinear elements, a tenth of the radius long at the needle.
The force is good to 3 %: it wavers as elements come to lie on the edge, and with 6 in place of 10 a radius.

Prints depth (mm), force (N), and the force over that of a flat punch on a linear half-space, 2 E a D / (1 - nu²).

Usage: indentation.py [DIAMETER_IN_MM DEPTH_IN_MM [ELEMENTS_PER_RADIUS]]      default 1 2 and 2 2
"""

import math
import sys
import unittest

from calculix import answer_options, graded, solve_deck

SIZE = 60.0          # mm
E, NU = 10e-3, 0.45  # N/mm²
EDGE = 0.3           # of the needle's radius
FINEST = 10          # elements per radius
NEAR, UNDER = 3, 2   # radii, out and down, in elements of that length
BEYOND = 24          # elements from there to the border
STEPS = 50
TESTED = (2, 1, 6), 0.02272  # arguments, N


def places(first, near):
    """From 0 to SIZE, evenly up to about `near`."""
    even = [first * i for i in range(round(near / first) + 1)]
    return even + [even[-1] + x for x in graded(first, SIZE - even[-1], BEYOND)[1:]]


def outline(a, depth):
    """Of the needle in its plane (r, z), from the axis outwards and up, 1e-4 of its radius above the tissue."""
    edge, length = EDGE * a, depth + 6 * a
    points = [((a - edge) * i / 5, 0) for i in range(5)]
    points += [(a - edge + edge * math.sin(t), edge - edge * math.cos(t)) for t in (math.pi / 12 * i for i in range(7))]
    points += [(a, edge + (length - edge) * i / 15) for i in range(1, 16)]
    return [(r, z + 1e-4 * a) for r, z in points]


def deck(a, depth, finest):
    """CalculiX's input."""
    first = a / finest
    rs, zs = places(first, NEAR * a), places(first, UNDER * a)

    def node(i, k):
        return k * len(rs) + i + 1

    nodes = [(r, -z) for z in zs for r in rs]
    outer = outline(a, depth)
    needle = len(nodes)
    nodes += outer + [(0.6 * r, 0.98 * z + 0.25 * a) for r, z in outer]
    tissue = [(node(i, k + 1), node(i + 1, k + 1), node(i + 1, k), node(i, k))
              for k in range(len(zs) - 1) for i in range(len(rs) - 1)]
    skin = [(needle + i + 1, needle + i + 2, needle + len(outer) + i + 2, needle + len(outer) + i + 1)
            for i in range(len(outer) - 1)]
    shear, bulk = E / 2 / (1 + NU), E / 3 / (1 - 2 * NU)

    def numbered(items, start):
        return [f"{i}," + ",".join(f"{x:.9g}" for x in item) for i, item in enumerate(items, start)]

    return "\n".join(
        ["*NODE"] + numbered([(r, z, 0) for r, z in nodes], 1) +
        ["*ELEMENT,TYPE=CAX4,ELSET=TISSUE"] + numbered(tissue, 1) +
        ["*ELEMENT,TYPE=CAX4,ELSET=NEEDLE"] + numbered(skin, len(tissue) + 1) +
        ["*SURFACE,NAME=TOP"] + [f"{i + 1},S3" for i in range(len(rs) - 1)] +
        ["*SURFACE,NAME=OUTLINE"] + [f"{len(tissue) + i + 1},S1" for i in range(len(skin))] +
        ["*NSET,NSET=NEEDLE"] + [str(i + 1) for i in range(needle, len(nodes))] +
        ["*NSET,NSET=HELD"] + [str(node(i, len(zs) - 1)) for i in range(len(rs))] +
        [str(node(len(rs) - 1, k)) for k in range(len(zs) - 1)] +
        ["*NSET,NSET=AXIS"] + [str(node(0, k)) for k in range(len(zs) - 1)] +
        ["*MATERIAL,NAME=SOFT", "*HYPERELASTIC,NEO HOOKE", f"{shear / 2:.9g},{2 / bulk:.9g}",
         "*MATERIAL,NAME=STIFF", "*ELASTIC", f"{1e4 * E},0.3",
         "*SOLID SECTION,ELSET=TISSUE,MATERIAL=SOFT", "*SOLID SECTION,ELSET=NEEDLE,MATERIAL=STIFF",
         "*SURFACE INTERACTION,NAME=SMOOTH", "*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR", f"{50 * E / first:.9g}",
         "*CONTACT PAIR,INTERACTION=SMOOTH,TYPE=SURFACE TO SURFACE", "TOP,OUTLINE",
         "*STEP,NLGEOM,INC=2000", "*STATIC", f"{1 / STEPS},1.,1e-6,{1 / STEPS}",
         "*BOUNDARY", "HELD,1,2", "AXIS,1,1", "NEEDLE,1,1", f"NEEDLE,2,2,{-depth}",
         "*NODE PRINT,NSET=NEEDLE,TOTALS=ONLY", "RF", "*END STEP", ""])


def read_totals(lines, depth):
    """(depth, force) of every increment, of the words of each line. CalculiX turns the plane by two degrees; the force is of all 360."""
    time, found = None, []
    for words in lines:
        if "time" in words:
            time = float(words[-1])
        elif time is not None and len(words) == 3:
            found.append((time * depth, -180 * float(words[1])))
            time = None
    return found


def solve(diameter, depth, finest=FINEST):
    """(depth in mm, force in N) up to the depth."""
    lines = solve_deck(lambda file: file.write(deck(diameter / 2, depth, finest)), timeout=1800)
    return read_totals(lines, depth)


class Indentation(unittest.TestCase):
    def test_force(self):
        case, expected = TESTED
        _, force = solve(*case)[-1]
        self.assertAlmostEqual(force / expected, 1, delta=1e-3)


if __name__ == "__main__":
    answer_options(__doc__)
    arguments = [float(word) for word in sys.argv[1:]]
    for case in [arguments] if arguments else [[1, 2], [2, 2]]:
        curve = solve(*case[:2], *map(int, case[2:]))
        print(f"{case[0]:g} mm thick")
        for deep, newtons in curve[:: max(1, len(curve) // 10)] + curve[-1:]:
            print(f"  {deep:6.3f} mm  {newtons:.5f} N  {newtons / (E * case[0] * deep / (1 - NU**2)):.3f}", flush=True)
