// SPDX-License-Identifier: MIT
// A device is not trusted: what it reads has to be a place that a hand can reach, and a rotation.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

#include "client/haptics/device.h"
#include "protocol/unit_quaternion.h"

namespace acus::haptics {

inline constexpr double kFarthestHandle = 2;  // m, of the handle from the device's origin, along each axis

// The reading itself. Throws DeviceError that names the number.
inline const Device::Reading& checked(const Device::Reading& reading) {
  char text[160];
  for (int i = 0; i < 3; ++i) {
    const double place = reading.pose.position[i];
    if (std::abs(place) <= kFarthestHandle) continue;
    std::snprintf(text, sizeof text, "the device reports %c = %g m; expected a place within %g m", "xyz"[i], place,
                  kFarthestHandle);
    throw DeviceError(text);
  }
  const Quaternion& q = reading.pose.orientation;
  const double length = protocol::quaternion_length(q.w, q.x, q.y, q.z);
  if (protocol::is_unit_length(length)) return reading;
  std::snprintf(text, sizeof text, "the device reports an orientation of length %g; expected 1", length);
  throw DeviceError(text);
}

}  // namespace acus::haptics
