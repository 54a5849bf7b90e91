// SPDX-License-Identifier: GPL-3.0-or-later
// Needles that bend, slide and are swept over tissue: whether surfaces bear shafts beside their paths.
//
// Each is an entry (entries.h) with a thin steel needle, 0.5 to 1.5 mm thick, that bends where the tissue is stiffer
// than itself. It is pushed along its axis by 60 mm; every other one by 30 mm, and then its base goes 40 mm sideways,
// in a random direction, and rests.
#pragma once

#include "tests/study/studies/entries.h"

namespace acus {

struct Shaft {
  Entry entry;
  double push = 60e-3;               // m, of the base, along the axis
  double sweep = 0;                  // m, then sideways
  Vector3 aside = Vector3::UnitX();  // unit, world
};

// The shaft of a number, on a block or on one of `meshes`.
Shaft random_shaft(int number, const std::vector<GmshMesh>& meshes);

struct ShaftOutcome {
  int ticks = 0;
  int borne_ticks = 0;       // in which a surface bore the shaft
  double unheld = 0;         // m, the most of all ticks
  double unheld_at_end = 0;  // m
  double largest_force = 0;  // N, at the base
  int inverted_ticks = 0;    // flagged
  std::uint32_t flags = 0;   // of all ticks
  double seconds = 0;        // of processor time in the ticks
};

ShaftOutcome run_shaft(const Shaft& shaft);

}  // namespace acus
