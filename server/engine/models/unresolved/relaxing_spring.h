// SPDX-License-Identifier: GPL-3.0-or-later
// A spring in tissue that relaxes (models/element/relaxation.h). One that yields by D(f_r) at rest, whatever D is,
// bears
//
//   f = G f_r - sum of g_i (1 - alpha_i) phi_i
//
// where it yields as much now, phi_i (N) the f_r to which branch i has crept.
#pragma once

#include "server/engine/models/element/relaxation.h"

namespace acus {

class RelaxingSpring {
 public:
  void relax(const RelaxationStep& law, const Branches& crept) {
    stiffening_ = law.stiffening;
    kept_ = law.given.dot(crept);
  }
  // f_r (N).
  double at_rest(double f) const { return (f + kept_) / stiffening_; }
  double stiffening() const { return stiffening_; }  // G

 private:
  double stiffening_ = 1, kept_ = 0;
};

}  // namespace acus
