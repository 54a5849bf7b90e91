// SPDX-License-Identifier: GPL-3.0-or-later
// The friction of a point of a shaft, along the shaft and about it.
//
// Friction opposes the slip of the shaft's surface, whatever its direction: with the slip delta = (a, b) along the
// shaft and about it (m, in the tick),
//
//   lambda = -F(|delta|) delta/|delta|                where it slips, F of slip_law.h; within the circle T where it
//   sticks.
//
// So a needle that spins fast goes in with little friction, and one that goes in straight feels no torque. Where only a
// share of the friction resists spin, b is taken at that share of the needle's radius (tick/insertion/shaft_rows.h).
// A shaft that is drawn back has the share r of the friction along itself: half of the circle is half of an ellipse
// (contact_block.h). Without torsion it is a friction along the shaft alone.
//
// It is solved fast as laws of one row each, with straight graphs, which meet it at a slip (a*, b*). With
// C = |a*|/|delta*|, S = |b*|/|delta*| and the tangent T' + c' |delta| of F at |delta*|, for r = 1:
//
//   along:  threshold T' C (1 - k S²),  viscosity k T' S²/|delta*| + c'
//   about:  threshold T' S (1 - k C²),  viscosity k T' C²/|delta*| + c';
//
// where the point sticks each row's threshold is what the other one's force leaves of the circle. The slip is the exact
// answer of the point alone with all other forces given (cone_contact()); laws and answer agree where all cones hold,
// and until then are followed in rounds (Rows::solve()). k is a share of the slope that the cone has where only one of
// a and b changes. In its own direction a slip may grow without more force, but the slopes of two rows resist that:
// with k = 1 shafts that wind and slip by nanometres need a hundred rounds. With k = 0 nothing holds the direction, and
// rounds do not end. A third takes one round where slip is steady, two or three where it begins.
#pragma once

#include <array>

#include "server/engine/laws/contact_block.h"
#include "server/engine/laws/laws.h"
#include "server/engine/laws/slip_law.h"

namespace acus {

struct FrictionCone {
  SlipLaw law;
  double back =
      1;  // r (-), > 0: friction of a shaft drawn back (its force along is positive) over that of one pushed in

  // Half axis along over that about, on the side of a force along (N).
  double stretch(double along) const { return along > 0 ? back : 1; }
};

// What the point alone comes to on the line delta = W lambda + delta_bar; W symmetric positive definite (m/N), 2 x 2.
DiskContact cone_contact(const FrictionCone& cone, const Eigen::Matrix2d& W, const Eigen::Vector2d& delta_bar);

// Of its two rows: along and about.
using ConeLaws = std::array<Law, 2>;

// `contact`: what the cone comes to.
ConeLaws laws_of_rows(const FrictionCone& cone, const DiskContact& contact);
// Refer to `cone`.
ConeLaws laws_of_disk(const FrictionCone& cone);

}  // namespace acus
