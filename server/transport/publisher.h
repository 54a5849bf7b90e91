// SPDX-License-Identifier: GPL-3.0-or-later
// The states socket (XPUB): who listens to what, and states encoded and sent to them, on the socket thread. Never
// waits. In real time a subscriber that does not keep up loses states, and nobody else does. In lockstep a state that a
// subscriber has no room for is held back, and with it the world, until there is room or patience ends.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <zmq.hpp>

#include "server/runtime/link.h"
#include "server/runtime/loaded_scene.h"
#include "server/runtime/topics.h"
#include "server/transport/listening.h"

namespace acus {

class Publisher {
 public:
  // Binds; throws CannotListen.
  Publisher(zmq::context_t& context, const std::string& endpoint, const Admission& admission, bool lockstep);

  zmq::socket_t& socket() { return socket_; }

  // Where it listens, with the port that a wildcard was resolved to.
  std::string endpoint() const { return socket_.get(zmq::sockopt::last_endpoint); }

  // States that some subscriber had no room for, the first of each series; the rest cannot be known.
  std::uint64_t dropped() const { return dropped_; }

  // Takes in the notices that wait, and returns the topics that are wanted.
  TopicSet update_subscriptions();

  // Sends what is held back, if anything; false if it still has to wait. Nothing may be published meanwhile.
  bool flush();

  void publish(const ForceRecord& record, const LoadedScene& world);
  void publish(const HapticRecord& record, const LoadedScene& world);
  void publish(const EventRecord& record, const LoadedScene& world);
  void publish(NeedleFrame& frame, const LoadedScene& world);
  void publish(const protocol::TissueShape& shape);
  void publish(const protocol::Stats& stats);

 private:
  void ask_about_doubts();
  void bound_queues(std::size_t bytes);
  template <class Message>
  void encode_and_send(const Message& message);
  bool try_to_send(const char* topic, const std::string& bytes);
  void send_where_room_is(const char* topic, const std::string& bytes);

  zmq::socket_t socket_;
  zmq::socket_t asking_;  // SUB, connected to socket_
  Subscriptions subscriptions_;
  std::string bytes_;        // the encoded state, reused
  std::size_t largest_ = 0;  // bytes of a state so far, rounded up
  bool waits_for_room_;
  std::uint64_t dropped_ = 0;

  const char* held_topic_ = nullptr;  // of the state in bytes_ that is held back, if one is
  std::chrono::steady_clock::time_point held_since_;
};

}  // namespace acus
