#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A rigid needle in a block, in a mesh that has it in it, solved by CalculiX (Debian: calculix-ccx): the reference for how
stiffly tissue holds a needle sideways.

The block: 100 mm, E = 10 kPa, nu = 0.45, held at all faces but the top. The needle: 1 mm thick, straight down from the
middle of the top. Quadratic bricks in rings around it, a quarter of a millimetre long at its tip, and wedges below the
tip; half of the block, with a plane of symmetry. Small displacements: the needle's surface goes aside by 0.1 mm and may
slide along its axis. Prints the force over that way (N/m) and the share of it that the last 2 mm bear.

Usage: needle_in_block.py [DEPTH_IN_MM...]      default 20 40 70
"""

import math
import sys
import unittest

from calculix import answer_options, graded, solve_deck

WIDTH, HEIGHT, RADIUS = 100.0, 100.0, 0.5  # mm
E, NU = 10e-3, 0.45                        # N/mm²
ASIDE = 0.1                                # mm
FINEST = 0.25                              # mm, of an element at the tip
FIGURES = {20: 203.4, 40: 385.4, 70: 675.1}  # N/m, with RINGS x SECTORS; 24 x 12: 203.0, 384.4, 673.2
RINGS, SECTORS, BESIDE, BELOW = 16, 8, 16, 14  # elements: outwards, around half, along the needle, below it


def with_middles(places):
    return [places[0]] + [x for a, b in zip(places, places[1:]) for x in ((a + b) / 2, b)]


class Mesh:
    """Nodes by (ring, sector, level), two steps an element; ring -1 and -2 are halfway to the axis and on it."""

    def __init__(self, depth):
        beside = [depth - place for place in graded(FINEST, depth, BESIDE)][::-1]
        below = [depth + place for place in graded(FINEST, HEIGHT - depth, BELOW)]
        self.levels = with_middles(beside + below[1:])
        self.out = with_middles(graded(RADIUS / 2 / (WIDTH / 2 - RADIUS), 1.0, RINGS))
        self.numbers, self.places, self.bricks, self.wedges = {}, [], [], []
        for k in range(0, len(self.levels) - 1, 2):
            for j in range(0, 2 * SECTORS, 2):
                self.add_sector(j, k)

    def node(self, i, j, k):
        j = 0 if i == -2 else j
        if (i, j, k) not in self.numbers:
            angle = math.pi * j / (2 * SECTORS)
            border = WIDTH / 2 / max(abs(math.cos(angle)), abs(math.sin(angle)))
            r = RADIUS * (i + 2) / 2 if i < 0 else RADIUS + self.out[i] * (border - RADIUS)
            self.places.append((r * math.cos(angle), r * math.sin(angle), -self.levels[k]))
            self.numbers[i, j, k] = len(self.places)
        return self.numbers[i, j, k]

    def element(self, corners, edges, k):
        low, middle, high = k + 2, k + 1, k  # levels go down
        return [self.node(*at, level) for at_all, level in
                ((corners, low), (corners, high), (edges, low), (edges, high), (corners, middle)) for at in at_all]

    def add_sector(self, j, k):
        for i in range(0, 2 * RINGS, 2):
            self.bricks.append(self.element([(i, j), (i + 2, j), (i + 2, j + 2), (i, j + 2)],
                                            [(i + 1, j), (i + 2, j + 1), (i + 1, j + 2), (i, j + 1)], k))
        if k >= 2 * BESIDE:
            self.wedges.append(self.element([(-2, 0), (0, j), (0, j + 2)], [(-1, j), (0, j + 1), (-1, j + 2)], k))

    def needle(self):
        return [n for (i, _, k), n in self.numbers.items()
                if (i == 0 and k <= 2 * BESIDE) or (i < 0 and k == 2 * BESIDE)]

    def held(self):
        return [n for (i, _, k), n in self.numbers.items() if i == 2 * RINGS or k == len(self.levels) - 1]

    def in_plane(self):
        """Of symmetry, and neither held nor the needle's."""
        others = set(self.needle()) | set(self.held())
        return [n for (i, j, _), n in self.numbers.items() if (j in (0, 2 * SECTORS) or i == -2) and n not in others]


def write(mesh, file):
    def line(numbers):
        texts = [str(n) for n in numbers]
        file.write(",\n".join(",".join(texts[i:i + 12]) for i in range(0, len(texts), 12)) + "\n")

    file.write("*NODE\n")
    for n, place in enumerate(mesh.places, 1):
        file.write(f"{n},{place[0]:.9g},{place[1]:.9g},{place[2]:.9g}\n")
    number = 0
    for kind, elements in (("C3D20", mesh.bricks), ("C3D15", mesh.wedges)):
        file.write(f"*ELEMENT,TYPE={kind},ELSET=TISSUE\n")
        for element in elements:
            number += 1
            line([number] + element)
    for name, nodes in (("HELD", mesh.held()), ("PLANE", mesh.in_plane()), ("NEEDLE", mesh.needle())):
        file.write(f"*NSET,NSET={name}\n" + "".join(f"{n}\n" for n in nodes))
    file.write(f"*MATERIAL,NAME=TISSUE\n*ELASTIC\n{E},{NU}\n*SOLID SECTION,ELSET=TISSUE,MATERIAL=TISSUE\n"
               f"*STEP\n*STATIC\n*BOUNDARY\nHELD,1,3\nPLANE,2,2\nNEEDLE,1,1,{ASIDE}\nNEEDLE,2,2\n"
               "*NODE PRINT,NSET=NEEDLE\nRF\n*END STEP\n")


def solve(depth):
    """Force over way (N/m), and the share of it on the last 2 mm."""
    mesh = Mesh(depth)
    rows = solve_deck(lambda file: write(mesh, file), timeout=600)
    forces = {int(row[0]): float(row[1]) for row in rows if len(row) == 4 and row[0].isdigit()}
    whole = sum(forces.values())
    last = sum(force for n, force in forces.items() if mesh.places[n - 1][2] <= -depth + 2)
    return 2e3 * whole / ASIDE, last / whole


class NeedleInBlock(unittest.TestCase):
    def test_figures(self):
        """needle_hold.cpp holds Acus to these."""
        stiffness, _ = solve(40.0)
        self.assertAlmostEqual(stiffness / FIGURES[40], 1, delta=1e-3)


if __name__ == "__main__":
    answer_options(__doc__)
    for text in sys.argv[1:] or ("20", "40", "70"):
        result = solve(float(text))
        print(f"{text} mm deep: {result[0]:.1f} N/m, {100 * result[1]:.1f} % of it on the last 2 mm", flush=True)
