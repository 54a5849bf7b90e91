// SPDX-License-Identifier: MIT
// What counts as a unit quaternion that comes from outside, and how it is made exact: one rule, so that whoever takes
// one gets the same bits.
#pragma once

#include <cmath>

#include "protocol/enums.h"

namespace acus::protocol {

inline double quaternion_length(double w, double x, double y, double z) {
  return std::hypot(std::hypot(w, x), std::hypot(y, z));
}

// NaN is none. Those that are accepted are divided by their length.
inline bool is_unit_length(double length) { return std::abs(length - 1) <= kQuaternionTolerance; }

}  // namespace acus::protocol
