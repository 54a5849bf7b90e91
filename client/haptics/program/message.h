// SPDX-License-Identifier: MIT
// The kit's local model, from a message of the topic `haptics`. The kit renders what lasts (`lasting_force`), not what
// the needle's own inertia adds for a tick, and takes the limits at which the needle as a whole gives way.
#pragma once

#include "client/haptics/local_model.h"
#include "protocol/messages.h"

namespace acus::haptics {

Pose pose_of(const protocol::Vector3& position, const protocol::Quaternion& orientation);

// What both topics tell alike: which tick it is, of which command, and the spin.
template <class Message>
LocalModel tick_of(const Message& message) {
  LocalModel model;
  model.epoch = message.epoch;
  model.tick = message.tick;
  model.time = message.time;
  model.seq = message.seq;
  model.echo = message.echo;
  model.age = message.age;
  model.stale = message.stale;
  model.spin = message.spin;
  return model;
}

LocalModel model_of(const protocol::Haptics& message);

}  // namespace acus::haptics
