// SPDX-License-Identifier: GPL-3.0-or-later
// A needle's base that a spring and a damper hold to a pose, as a robot's flange or a hand does, instead of being where
// it is told. The holder's pose is a (position, orientation), prescribed; the base's is b. On the needle act, about the
// base,
//
//   force   k (a - b) + c (a' - b')
//   torque  k_r log(R_a R_bᵀ) + c_r omega
//
// k (N/m) and k_r (N m/rad) the same in all directions, velocities backward differences over the tick; omega is that of
// the relative turn R_a R_bᵀ. Against a step of the base (translation, rotation vector; world) the wrench falls by
// K = diag(k + c/h, k_r + c_r/h) times the step, but for terms in proportion to the angle between both.
//
// Limits. Holder and base are less than half a turn apart: beyond it the spring pulls the other way round. k, k_r ->
// infinity: a base that is where it is told. All that holds is passive: what the damper takes is lost, and the spring
// gives back no more than it got.
#pragma once

#include "server/engine/math/factor/block_tridiagonal.h"
#include "server/engine/math/types.h"
#include "server/engine/models/element/material.h"

namespace acus {

class HeldBase {
 public:
  HeldBase(const BaseHold& hold, double h) : hold_(hold), h_(h) {}

  // Starts a tick: where the holder was at its start and is at its end, and where the base is at its start.
  void begin(const Pose& holder_before, const Pose& holder, const Pose& base);

  // Where the base would be if the holder had carried it along as it stood.
  Pose carried_along() const;

  // On the needle (N, N m), with the base there at the end of the tick.
  Vector6 wrench(const Pose& base) const;

  Vector6 tangent() const;  // the diagonal of K

 private:
  BaseHold hold_;
  double h_;
  Pose before_, holder_, base_;
};

}  // namespace acus
