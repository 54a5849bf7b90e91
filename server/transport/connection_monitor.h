// SPDX-License-Identifier: GPL-3.0-or-later
// Which connections of a socket begin, are open, and end, by the file descriptor that connection_of() gives for a
// message. A message may be read after its connection has ended.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <unordered_set>
#include <zmq.hpp>

#include "server/transport/rate_limiter.h"

namespace acus {

struct ConnectionChange {
  int connection = -1;
  bool begun = false;  // or else ended
};

class ConnectionMonitor {
 public:
  // `name` tells it from the other monitors of the context.
  ConnectionMonitor(zmq::context_t& context, zmq::socket_t& socket, const std::string& name);

  zmq::socket_t& socket() { return events_; }  // readable when a connection has begun or ended
  std::optional<ConnectionChange> next_change();                             // does not wait
  bool is_open(int connection) const { return open_.contains(connection); }  // as of the last change

 private:
  void log_failure(std::int32_t reason);

  zmq::socket_t events_;
  RateLimiter log_limit_;
  std::unordered_set<int> open_;
};

// Which connection a message came through, by a frame that its client sent: the routing frame does not always tell.
// Descriptors are used again, after next_change() has told of their end.
int connection_of(zmq::message_t& message);

}  // namespace acus
