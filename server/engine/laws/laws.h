// SPDX-License-Identifier: GPL-3.0-or-later
// The laws between needle and tissue: each a graph of the force lambda (N, of the tissue on the needle, along the row's
// direction n) over the distance or displacement delta (m, delta = nᵀ(u_needle - u_tissue)). The solver looks for the
// point where the graph meets the line delta = W lambda + delta_bar, W > 0 (Duriez et al. 2009, section 3, Fig. 5). All
// graphs fall monotonically, the disk's for a given normal force, so there is exactly one such point.
//
//  bilateral              unilateral, cap f            friction, threshold T, viscosity c
//  (tip and shaft path)   (contact, puncture, cutting)
//
//   lambda                lambda                        lambda
//     |                     f ----+                      ----_____+ T
//     |                           |                               |          slope -c
//   --+-- delta                   |                          -----+----- delta
//     |                       ----+-------- delta                 |
//     |                           0                            -T +-----____
//
//  delta = 0              delta > 0: lambda = 0         delta = 0: |lambda| <= T       (stick)
//                         delta = 0: 0 <= lambda <= f   delta > 0: lambda = -T - c delta (slip)
//                         delta < 0: lambda = f         delta < 0: lambda =  T - c delta
//
// A bilateral row may be soft: delta = -s lambda, with a compliance s of its own.
//
// disk: the two rows of contact friction, lambda (2-vector) within the disk of radius C + mu * (force of the normal
// row); stick where it is inside, opposed to delta where it is on the rim (Mohr and Coulomb's cone with the cohesion C,
// with the normal force known). C is zero on a free surface; a tip that slides along an interface cuts, C = f_c. A disk
// without normal row is the friction of a shaft (friction_cone.h).
//
// Friction has a static threshold, above the dynamic one (paper, section 2.5). With both in one graph it would not be
// monotone and the answer not unique; so a point that stuck at the end of the last tick has T = static, a point that
// slipped T = dynamic, fixed during the tick. A stick thus breaks at the static force and drops to the dynamic one a
// tick later.
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>

#include "server/engine/math/types.h"

namespace acus {

enum class LawKind : std::uint8_t {
  bilateral,
  unilateral,
  friction,
  disk_first,  // the next row is its disk_second
  disk_second
};

struct FrictionCone;

struct Law {
  LawKind kind = LawKind::bilateral;
  double limit = 0;                    // f or T (N), >= 0, may be infinite; disks: mu (-)
  double viscosity = 0;                // c (N/m), friction only: force per displacement in this tick
  int normal_row = -1;                 // disks; -1: none
  double cohesion = 0;                 // C (N), >= 0, disks only
  double compliance = 0;               // s (m/N), >= 0, bilateral only
  const FrictionCone* cone = nullptr;  // of disks without normal row, and of curved friction; lives as long as the law
};

// lambda of friction along a shaft alone whose graph is a cone's (friction_cone.h).
double cone_force(const FrictionCone& cone, double compliance, double delta_bar);

// lambda of a one-row law on the line delta = compliance * lambda + delta_bar.
inline double law_force(const Law& law, double compliance, double delta_bar) {
  assert(law.limit >= 0 && law.viscosity >= 0 && !(compliance + law.compliance <= 0));
  const double stick = -delta_bar / (compliance + law.compliance);
  switch (law.kind) {
    case LawKind::unilateral:
      return std::clamp(stick, 0.0, law.limit);
    case LawKind::friction: {
      if (law.cone != nullptr) return cone_force(*law.cone, compliance, delta_bar);
      if (std::abs(stick) <= law.limit) return stick;
      const double against = std::copysign(law.limit, stick);
      const double slip = (delta_bar + compliance * against) / (1 + law.viscosity * compliance);
      return against - law.viscosity * slip;
    }
    default:
      return stick;
  }
}

// One fixed-point step towards the disk law from (lambda, delta); `compliance` bounds the 2 x 2 block from above.
inline Eigen::Vector2d disk_force(double radius, double compliance, const Eigen::Vector2d& lambda,
                                  const Eigen::Vector2d& delta) {
  assert(!(radius < 0) && !(compliance <= 0));
  const Eigen::Vector2d target = lambda - delta / compliance;
  const double norm = target.norm();
  return norm <= radius ? target : Eigen::Vector2d(target * (radius / norm));
}

}  // namespace acus
