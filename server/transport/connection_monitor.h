// SPDX-License-Identifier: GPL-3.0-or-later
// Tells which connections of a socket have ended, by the file descriptor that connection_of() gives for a message.
#pragma once

#include <optional>
#include <zmq.hpp>

namespace acus {

class ConnectionMonitor {
 public:
  ConnectionMonitor(zmq::context_t& context, zmq::socket_t& socket);

  zmq::socket_t& socket() { return events_; }  // readable when a connection has ended
  std::optional<int> next_ended();             // does not wait

 private:
  zmq::socket_t events_;
};

// Which connection a message came through. Descriptors are used again, after next_ended() has told of their end.
int connection_of(zmq::message_t& message);

}  // namespace acus
