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
// share of the friction resists spin, b is taken at that share of the needle's radius
// (tick/insertion/finding/vertex_contacts.h). A shaft that is drawn back has the share r of the friction along itself:
// half of the circle is half of an ellipse (contact_block.h). Without torsion it is a friction along the shaft alone.
//
// Newton's method takes its tangent at a slip delta* (pivoting.h). With the unit vector e along lambda*, for r = 1,
//
//   delta = delta* - D (lambda - lambda*),   D = e eᵀ/F' + (I - e eᵀ) |delta*|/F;
//
// where the point sticks D = 0. The slip is the exact answer of the point alone with all other forces given
// (cone_contact()); where all cones hold, each is its own answer, and the tangents are those there.
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
// `near`: as for disk_contact().
DiskContact cone_contact(const FrictionCone& cone, const Eigen::Matrix2d& W, const Eigen::Vector2d& delta_bar,
                         const Eigen::Vector2d& near = Eigen::Vector2d::Zero());

// The tangent of a cone: delta = offset - give lambda.
struct ConeTangent {
  bool slips = false;
  Eigen::Matrix2d give = Eigen::Matrix2d::Zero();    // D (m/N), symmetric, positive definite where it slips
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  // m
};

// At what the cone comes to; exact for r = 1, else for a slip along or about the shaft. Where its force does not rise
// with the slip, D is kSteepest times `compliance` (m/N) in the slip's direction: at the answer the forces do not
// depend on D.
ConeTangent cone_tangent(const FrictionCone& cone, const DiskContact& contact, double compliance);
inline constexpr double kSteepest = 1e6;

// Of its two rows, along and about; they refer to `cone`.
std::array<Law, 2> laws_of_disk(const FrictionCone& cone);

}  // namespace acus
