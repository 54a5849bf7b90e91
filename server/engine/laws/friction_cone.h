// SPDX-License-Identifier: GPL-3.0-or-later
// One friction along and about a shaft.
//
// Coulomb's friction opposes the slip of the shaft's surface, whatever its direction: with the slip delta = (a, b)
// along the shaft and about it (m, in the tick),
//
//   lambda = -T delta/|delta| - c delta         where it slips; within the circle of radius T where it sticks.
//
// So a needle that spins fast goes in with little friction, and one that goes in straight feels no torque. Where only a
// share of the friction resists spin, b is taken at that share of the needle's radius (tick/insertion/shaft_rows.h).
//
// It is a disk (laws.h), whose two rows are one law. They are solved fast as two laws of one row each, which meet it at
// a slip (a*, b*) and have a share k of its slope there: with C = |a*|/|delta*| and S = |b*|/|delta*|,
//
//   along:  threshold T C (1 - k S²),  viscosity k T S²/|delta*| + c
//   about:  threshold T S (1 - k C²),  viscosity k T C²/|delta*| + c;
//
// where the point sticks each row's threshold is what the other one's force leaves of the circle. The slip is the exact
// answer of the disk alone with all other forces given (disk_contact()); laws and answer agree where all cones hold,
// and until then are followed in turn (Rows::solve()). In its own direction a slip may grow without more force, but the
// slopes of two rows resist that: with k = 1 shafts that wind and slip by nanometres need a hundred turns. With k = 0
// nothing holds the direction, and turns do not end. A third of the slope takes one turn where slip is steady, two or
// three where it begins.
#pragma once

#include "server/engine/laws/contact_block.h"
#include "server/engine/laws/laws.h"

namespace acus {

inline constexpr double kConeSlope = 0.3;  // k (-), with which laws and answer meet

struct FrictionCone {
  double threshold = 0;  // T (N), >= 0
  double viscosity = 0;  // c (N/m), >= 0: force per displacement in this tick
};

// Of its two rows: along and about, or the first and second of the disk.
using ConeLaws = std::array<Law, 2>;

// `contact`: what the disk comes to; `slope`: k.
ConeLaws laws_of_rows(const FrictionCone& cone, const DiskContact& contact, double slope = kConeSlope);
ConeLaws laws_of_disk(const FrictionCone& cone);

}  // namespace acus
