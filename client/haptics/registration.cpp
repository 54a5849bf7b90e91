// SPDX-License-Identifier: MIT
#include "client/haptics/registration.h"

namespace acus::haptics {

Pose Registration::base_of(const Pose& device) const {
  const Quaternion& turn = workspace_.world_from_device;
  const Quaternion turned = turn * (device.orientation * device_at_.orientation.conjugate()) * turn.conjugate();
  return {base_at_.position + workspace_.scale * (turn * (device.position - device_at_.position)),
          normalized(turned * base_at_.orientation)};
}

Wrench Registration::at_device(const Wrench& at_base) const {
  const Quaternion back = workspace_.world_from_device.conjugate();
  return {workspace_.force_scale * (back * at_base.force), torque_scale() * (back * at_base.torque)};
}

}  // namespace acus::haptics
