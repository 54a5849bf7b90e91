// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/publisher.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <bit>
#include <random>

#include "protocol/codec.h"
#include "server/engine/math/rotation.h"
#include "server/runtime/convert.h"

namespace acus {
namespace {

// Of a subscriber that does not keep up: as many states, or as few large ones as make so many bytes.
constexpr std::size_t kQueuedStates = 4096, kQueuedBytes = 64 << 20, kFewestQueued = 64;
constexpr int kStatesLinger = 200;  // ms to deliver what is queued at the end
constexpr auto kHoldPatience = std::chrono::seconds(10);
constexpr int kNoticesAtATime = 256;           // taken in at a time
constexpr std::int64_t kMaxNoticeBytes = 512;  // beyond it the subscriber is disconnected; a handshake needs about 300
constexpr const char* kAskingEndpoint = "inproc://subscriptions";

std::string random_mark() {
  std::random_device random;
  std::string mark = "?";
  for (int i = 0; i < 4; ++i) mark += std::to_string(random());
  return mark;
}

// What all that is told of a needle at every tick begins with.
template <class Message>
void put_tick(const ForceRecord& record, const LoadedScene& world, Message& message) {
  message.epoch = record.epoch;
  message.tick = record.tick;
  message.time = record.time;
  message.needle = world.hello.needles[static_cast<std::size_t>(record.needle)].name;
  message.age = record.watch.age();
  message.echo = record.origin.time;
  message.stale = record.watch.stale();
  message.flags = record.flags;
}

}  // namespace

Publisher::Publisher(zmq::context_t& context, const std::string& endpoint, const Admission& admission, bool lockstep)
    : socket_(context, zmq::socket_type::xpub),
      asking_(context, zmq::socket_type::sub),
      subscriptions_(random_mark()),
      waits_for_room_(lockstep) {
  bound_queues(1);
  socket_.set(zmq::sockopt::linger, kStatesLinger);
  socket_.set(zmq::sockopt::xpub_nodrop, true);
  socket_.set(zmq::sockopt::maxmsgsize, kMaxNoticeBytes);
  socket_.bind(kAskingEndpoint);
  asking_.set(zmq::sockopt::linger, 0);
  asking_.connect(kAskingEndpoint);
  listen(socket_, "--states", endpoint, admission);
}

TopicSet Publisher::update_subscriptions() {
  zmq::message_t notice;
  for (int i = 0; i < kNoticesAtATime && socket_.recv(notice, zmq::recv_flags::dontwait); ++i) {
    subscriptions_.apply(notice.to_string_view());
  }
  ask_about_doubts();
  return subscriptions_.wanted();
}

// The answer is among the next notices.
void Publisher::ask_about_doubts() {
  const auto prefixes = subscriptions_.begin_question();
  if (prefixes.empty()) return;
  asking_.set(zmq::sockopt::subscribe, subscriptions_.mark());
  for (const std::string& prefix : prefixes) {
    asking_.set(zmq::sockopt::subscribe, prefix);
    asking_.set(zmq::sockopt::unsubscribe, prefix);
  }
  asking_.set(zmq::sockopt::unsubscribe, subscriptions_.mark());
}

bool Publisher::flush() {
  if (!held_topic_ || try_to_send(held_topic_, bytes_)) {
    held_topic_ = nullptr;
    return true;
  }
  if (std::chrono::steady_clock::now() - held_since_ < kHoldPatience) return false;
  spdlog::warn("a subscriber took no states for {} s; states that it has no room for are dropped from here on",
               kHoldPatience.count());
  waits_for_room_ = false;
  send_where_room_is(held_topic_, bytes_);
  held_topic_ = nullptr;
  return true;
}

// A queue's limit counts states. It shrinks with the largest state so far, to a power of two so that it seldom does.
void Publisher::bound_queues(std::size_t bytes) {
  if (bytes <= largest_) return;
  largest_ = std::bit_ceil(bytes);
  socket_.set(zmq::sockopt::sndhwm,
              static_cast<int>(std::clamp(kQueuedBytes / largest_, kFewestQueued, kQueuedStates)));
}

void Publisher::publish(const ForceRecord& record, const LoadedScene& world) {
  protocol::Force force;
  put(record.report, force);
  put_tick(record, world, force);
  force.fresh = record.watch.fresh_share();
  force.lost = record.origin.lost;
  force.reordered = record.origin.reordered;
  force.limited = record.watch.limited();
  force.haptic_force = to_wire(record.watch.force_share() * record.report.base_force);
  force.haptic_torque = to_wire(record.watch.force_share() * record.report.base_torque);
  force.solver = record.solver;
  encode_and_send(force);
}

void Publisher::publish(const HapticRecord& record, const LoadedScene& world) {
  const NeedleReport& needle = record.force.report;
  const double share = record.force.watch.force_share();
  protocol::Haptics haptics;
  put_tick(record.force, world, haptics);
  haptics.seq = needle.command_seq;
  haptics.position = to_wire(needle.commanded.position);
  haptics.orientation = to_wire(needle.commanded.orientation * rotation_exp({-needle.spin, 0, 0}));
  haptics.spin = needle.spin;
  haptics.force = to_wire(share * needle.base_force);
  haptics.torque = to_wire(share * needle.base_torque);
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column)
      haptics.stiffness.push_back(share * record.stiffness.stiffness(row, column));
  haptics.forward = record.stiffness.forward;
  haptics.backward = record.stiffness.backward;
  haptics.forward_limit = record.stiffness.forward_limit;
  haptics.backward_limit = record.stiffness.backward_limit;
  haptics.lasting_force = to_wire(Vector3(share * record.stiffness.lasting.head<3>()));
  haptics.lasting_torque = to_wire(Vector3(share * record.stiffness.lasting.tail<3>()));
  haptics.forward_yield = record.stiffness.forward_yield;
  haptics.backward_yield = record.stiffness.backward_yield;
  encode_and_send(haptics);
}

void Publisher::publish(const EventRecord& record, const LoadedScene& world) {
  encode_and_send(to_wire(record.event, record.epoch, record.time, world.simulation.scene()));
}

void Publisher::publish(NeedleFrame& frame, const LoadedScene& world) {
  frame.shape.needle = world.hello.needles[static_cast<std::size_t>(frame.needle)].name;
  encode_and_send(frame.shape);
}

void Publisher::publish(const protocol::TissueShape& shape) { encode_and_send(shape); }
void Publisher::publish(const protocol::Stats& stats) { encode_and_send(stats); }

template <class Message>
void Publisher::encode_and_send(const Message& message) {
  protocol::encode(message, bytes_);
  bound_queues(bytes_.size());
  if (try_to_send(Message::kType, bytes_)) return;
  if (!waits_for_room_) return send_where_room_is(Message::kType, bytes_);
  held_topic_ = Message::kType;
  held_since_ = std::chrono::steady_clock::now();
}

// A subscriber without room loses this state, and further ones, which ZeroMQ does not tell of, until it has room again.
void Publisher::send_where_room_is(const char* topic, const std::string& bytes) {
  ++dropped_;
  socket_.set(zmq::sockopt::xpub_nodrop, false);
  try_to_send(topic, bytes);
  socket_.set(zmq::sockopt::xpub_nodrop, true);
}

// False if a subscriber that may still lose a state has no room, which ZeroMQ says before it takes the first frame.
bool Publisher::try_to_send(const char* topic, const std::string& bytes) {
  const auto more = zmq::send_flags::sndmore | zmq::send_flags::dontwait;
  if (!socket_.send(zmq::buffer(std::string_view(topic)), more)) return false;
  socket_.send(zmq::buffer(bytes), zmq::send_flags::dontwait);
  return true;
}

}  // namespace acus
