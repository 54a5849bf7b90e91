// SPDX-License-Identifier: MIT
// Two hands on one needle, as a teacher's and a pupil's. With the ways d1 and d2 of both handles from where they began
// and the share s of the first, 0 to 1,
//
//   d = s d1 + (1 - s) d2                                     way of the needle's base,
//   F1 = s F + k (d2 - d1),   F2 = (1 - s) F + k (d1 - d2)    what the hands feel,
//
// F is what one hand alone would feel on the way d: the kit's wrench, from the one account that both hands pay into.
// For a constant share the hands give to needle and spring what these store or use up, neither more nor less,
//
//   -F1'd1/dt - F2'd2/dt = -F'dd/dt + d/dt k/2 |d1 - d2|².
//
// A share of 1 leaves the needle to the first hand, and the other is led by the spring alone. As a share changes, the
// needle goes over from one way to the other; the account of d pays for that.
//
// What comes late, from another process or over a network, can make energy as every delay can: each device has an
// account of its own besides (passivity.h), so that neither hand ever gets more from its device than it has put in.
#pragma once

#include <optional>

#include "client/haptics/coupling.h"
#include "client/haptics/passivity.h"
#include "client/haptics/ramp.h"
#include "client/haptics/vectors.h"

namespace acus::haptics {

struct SharedHandOptions {
  double stiffness = 200;      // N/m, >= 0, of the spring between the hands; at most half of what the device may render
  double force_growth = 2000;  // N/s, > 0, as in KitOptions
  double ramp = 0.1;           // s, >= 0, in which the other hand is felt, or no longer
};

// One of the two hands. All wrenches and ways in one frame of both (device.h).
class SharedHand {
 public:
  // Throws std::invalid_argument.
  explicit SharedHand(const DeviceProperties& properties, const SharedHandOptions& options = {});

  // A sample, `elapsed` s after the last one. `moved`: way of the own handle since then; `felt`: F, with what springs
  // of tissue and coupling store of it (J); `ahead`: way of the other handle less that of the own one, nothing without
  // another hand.
  Wrench step(double elapsed, const Vector6& moved, const Wrench& felt, double stored, double share,
              const std::optional<Vector6>& ahead);

  const Passivity& passivity() const { return passivity_; }
  double stiffness() const { return stiffness_; }  // k, N/m

 private:
  Vector6 spring(const Vector6& ahead) const;

  DeviceProperties properties_;
  SharedHandOptions options_;
  Coupling coupling_;
  Passivity passivity_;
  double stiffness_, turning_;  // k of translation (N/m) and rotation (N m/rad)
  Ramp ramp_;
  Vector6 ahead_;  // newest known
  Wrench before_;
};

}  // namespace acus::haptics
