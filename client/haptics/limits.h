// SPDX-License-Identifier: MIT
// What a device may be asked for: no more than it can exert, and no force that grows faster than a hand should meet. A
// force that falls, as at a puncture, is never held up.
#pragma once

#include <algorithm>

#include "client/haptics/coupling.h"
#include "client/haptics/vectors.h"

namespace acus::haptics {

// The vector no longer than `largest`.
inline Vector3 limited(const Vector3& v, double largest) {
  const double length = norm(v);
  return length > largest ? largest / length * v : v;
}

// A force whose magnitude grows by at most `growth` from one sample to the next.
inline Vector3 limited_growth(const Vector3& before, const Vector3& wanted, double growth) {
  return limited(wanted, norm(before) + growth);
}

// The wrench within what the device can exert and `growth` (N a sample) lets it grow to; torques grow in proportion to
// their limit. `most`: N, of the force.
inline Wrench within_limits(const Wrench& before, const Wrench& wanted, const DeviceProperties& properties,
                            double growth, double most) {
  const double strongest = properties.translation.largest_force, twist = properties.rotation.largest_force;
  const double turning_growth = strongest > 0 ? growth * twist / strongest : twist;
  return {limited_growth(before.force, limited(wanted.force, std::min(most, strongest)), growth),
          limited_growth(before.torque, limited(wanted.torque, twist), turning_growth)};
}

}  // namespace acus::haptics
