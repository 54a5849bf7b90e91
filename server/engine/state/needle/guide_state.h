// SPDX-License-Identifier: GPL-3.0-or-later
// What a guide remembers from tick to tick; tick/guides.h says what it does.
#pragma once

#include "server/engine/math/types.h"
#include "server/engine/state/needle/base_state.h"

namespace acus {

struct GuideState {
  BaseState motion;                  // of the hole
  double s = 0;                      // m, of Q along the needle
  Vector3 across = Vector3::Zero();  // N, force of the last tick across the axis
  double along = 0;                  // N, friction of the last tick

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("motion", self.motion);
    visit("s", self.s);
    visit("across", self.across);
    visit("along", self.along);
  }
};

}  // namespace acus
