// SPDX-License-Identifier: GPL-3.0-or-later
// The socket thread: serves the commands socket (ROUTER), feeds the publisher, and answers requests once the simulation
// thread has carried them out. protocol/README.md is what clients may rely on.
//
// In lockstep one request is dealt with after the other, and commands between two of them in the order in which they
// came, so that the same messages give the same run.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <zmq.hpp>

#include "protocol/codec.h"
#include "server/runtime/link.h"
#include "server/transport/answers.h"
#include "server/transport/connection_guard.h"
#include "server/transport/connection_monitor.h"
#include "server/transport/inbox.h"
#include "server/transport/listening.h"
#include "server/transport/requests.h"
#include "server/transport/state_feed.h"
#include "server/transport/zap_handler.h"

namespace acus {

struct EndpointOptions : RequestOptions {
  std::string commands = protocol::kDefaultCommandsEndpoint;
  std::string states = protocol::kDefaultStatesEndpoint;
  std::string record;  // file to record into from the first tick on; empty: none
  Admission admission;
};

class Endpoint {
 public:
  // Binds both sockets; throws CannotListen, RecordingError. `world` is the one the simulation thread starts with.
  Endpoint(LoadedScene& world, const EndpointOptions& options, Link& link);

  std::string commands_endpoint() const { return commands_.get(zmq::sockopt::last_endpoint); }
  std::string states_endpoint() const { return feed_.endpoint(); }

  // Serves until the simulation thread has finished and everything it said is sent, or until `signals` (a file
  // descriptor) becomes readable. Calls each_turn() after `longest_turn` or a second at the latest.
  void run(int signals, std::chrono::milliseconds longest_turn, const std::function<void()>& each_turn);

  // What is simulated and how, in a line for people.
  std::string standing() const;

  std::uint64_t rejected() const { return answers_.rejected(); }
  // Whether a thread is at work that outlives the endpoint: it loads a scene, or writes a snapshot.
  bool leaves_thread() const { return requests_.leaves_thread(); }
  // Once the simulation thread has ended; false where something of a recording is missing.
  bool finish_recording() { return requests_.finish_recordings(); }
  std::uint64_t dropped() const { return feed_.dropped(); }

 private:
  bool wait_for_work(int signals, std::chrono::milliseconds longest_turn);
  bool listening() const;

  void receive_messages();
  std::optional<Arrived> next_message();
  bool may_overtake(const Arrived& message) const;
  void handle(const Arrived& message);
  void notice_connections();

  const bool lockstep_;
  Link& link_;
  zmq::context_t context_;
  std::optional<ZapHandler> zap_;  // with keys
  zmq::socket_t commands_;
  Inbox inbox_;
  Peers peers_;
  Answers answers_;
  ConnectionMonitor connections_;
  StateFeed feed_;
  std::optional<ConnectionGuard> guard_;
  Requests requests_;
};

}  // namespace acus
