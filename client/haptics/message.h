// SPDX-License-Identifier: MIT
// Between the kit and the protocol: the local model of a message of the topic `haptics`, and the `pose` that sends the
// needle where the kit wants it. The kit itself needs neither; whoever includes this has messages (acus::protocol).
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "client/haptics/kit.h"
#include "client/haptics/local_model.h"
#include "protocol/messages.h"

namespace acus::haptics {

inline Pose pose_of(const protocol::Vector3& position, const protocol::Quaternion& orientation) {
  return {{position}, normalized({orientation.w, orientation.x, orientation.y, orientation.z})};
}

// What the topics `force` and `haptics` tell alike: which tick it is, of which command, and the spin.
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

// The force that lasts (`lasting_force`, without the inertia of the needle in this tick), the stiffness, and the limits
// at which the whole needle slides, cuts or punctures.
inline LocalModel model_of(const protocol::Haptics& message) {
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

// Whether an event is one that a hand feels: the needle goes through a surface or a border, or leaves it.
inline bool is_felt(const protocol::Event& event) {
  return event.kind == protocol::EventKind::puncture || event.kind == protocol::EventKind::crossing ||
         event.kind == protocol::EventKind::release;
}

// `now`: s on the caller's clock; models repeat it as `echo`.
inline protocol::Pose message_of(const std::string& needle, const Kit::Answer& answer, double now) {
  protocol::Pose pose;
  pose.needle = needle;
  pose.seq = answer.seq;
  pose.time = now;
  pose.position = answer.base.position.at;
  const Quaternion& q = answer.base.orientation;
  pose.orientation = {q.w, q.x, q.y, q.z};
  return pose;
}

}  // namespace acus::haptics
