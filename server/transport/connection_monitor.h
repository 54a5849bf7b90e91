// SPDX-License-Identifier: GPL-3.0-or-later
// Which connections of a socket are open, and which have ended, by the file descriptor that connection_of() gives for a
// message. A message may be read after its connection has ended.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_set>
#include <zmq.hpp>

#include "server/transport/rate_limiter.h"

namespace acus {

class ConnectionMonitor {
 public:
  ConnectionMonitor(zmq::context_t& context, zmq::socket_t& socket);

  zmq::socket_t& socket() { return events_; }  // readable when a connection has begun or ended
  std::optional<int> next_ended();             // does not wait
  bool is_open(int connection) const { return open_.contains(connection); }  // as of when next_ended() gave none

 private:
  void log_failure(std::int32_t reason);

  zmq::socket_t events_;
  RateLimiter log_limit_;
  std::unordered_set<int> open_;
};

// Which connection a message came through, by a frame that its client sent: the routing frame does not always tell.
// Descriptors are used again, after next_ended() has told of their end.
int connection_of(zmq::message_t& message);

}  // namespace acus
