// SPDX-License-Identifier: MIT
#include "client/haptics/program/message.h"

#include <algorithm>
#include <cstddef>

namespace acus::haptics {

Pose pose_of(const protocol::Vector3& position, const protocol::Quaternion& orientation) {
  return {{position}, normalized({orientation.w, orientation.x, orientation.y, orientation.z})};
}

LocalModel model_of(const protocol::Haptics& message) {
  LocalModel model = tick_of(message);
  model.base = pose_of(message.position, message.orientation);
  model.felt = {{message.lasting_force}, {message.lasting_torque}};
  const std::size_t known = std::min<std::size_t>(message.stiffness.size(), 36);
  for (std::size_t i = 0; i < known; ++i)
    model.stiffness(static_cast<int>(i / 6), static_cast<int>(i % 6)) = message.stiffness[i];
  model.put_limits(message.forward_yield, message.backward_yield,
                   message.forward_limit == protocol::ModelLimit::cutting);
  return model;
}

}  // namespace acus::haptics
