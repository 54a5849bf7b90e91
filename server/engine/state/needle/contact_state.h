// SPDX-License-Identifier: GPL-3.0-or-later
// What a contact of a needle (tick/contact/contact.h) remembers from tick to tick, whatever its kind: its forces on the
// needle in the last tick, and what its springs have crept to in tissue that relaxes.
#pragma once

#include "server/engine/math/types.h"
#include "server/engine/models/element/relaxation.h"

namespace acus {

// Per branch of a relaxation (tick/insertion/spring_memory.h).
struct Creep {
  Eigen::Matrix<double, 3, Branches::RowsAtCompileTime> across =
      Eigen::Matrix<double, 3, Branches::RowsAtCompileTime>::Zero();  // m, world
  Branches along = Branches::Zero();                                  // m in a path, N of a dimple or groove

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("across", self.across);
    visit("along", self.along);
  }
};

struct ContactState {
  double along = 0;                  // N, along the contact's axis: a surface's normal, a path, a guide
  Vector3 across = Vector3::Zero();  // N, world, across that
  double torsion = 0;                // N, about it, at the share of the radius that torsional friction has
  bool sliding = true;               // along it, or about it if there is torsional friction
  Creep creep{};

  void forget_forces() {
    along = torsion = 0;
    across.setZero();
  }

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("along", self.along);
    visit("across", self.across);
    visit("torsion", self.torsion);
    visit("sliding", self.sliding);
    visit("creep", self.creep);
  }
};

}  // namespace acus
