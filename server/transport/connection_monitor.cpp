// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/connection_monitor.h"

#include <cstdint>
#include <cstring>

namespace acus {

namespace {

constexpr const char* kEvents = "inproc://connections";

}  // namespace

ConnectionMonitor::ConnectionMonitor(zmq::context_t& context, zmq::socket_t& socket)
    : events_(context, zmq::socket_type::pair) {
  if (zmq_socket_monitor(socket.handle(), kEvents, ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_DISCONNECTED) != 0)
    throw zmq::error_t();
  events_.set(zmq::sockopt::rcvhwm, 0);  // at a limit ZeroMQ's own thread would wait for this one
  events_.connect(kEvents);
}

// Two frames: the number of the event (16 bits) and its value (32 bits), then the endpoint.
std::optional<int> ConnectionMonitor::next_ended() {
  zmq::message_t event, endpoint;
  while (events_.recv(event, zmq::recv_flags::dontwait)) {
    [[maybe_unused]] const auto received = events_.recv(endpoint, zmq::recv_flags::none);
    std::uint16_t number = 0;
    std::int32_t connection = -1;
    std::memcpy(&number, event.data(), sizeof number);
    std::memcpy(&connection, event.data<char>() + sizeof number, sizeof connection);
    if (number == ZMQ_EVENT_ACCEPTED) {
      open_.insert(connection);
    } else {
      open_.erase(connection);
      return connection;
    }
  }
  return std::nullopt;
}

int connection_of(zmq::message_t& message) { return zmq_msg_get(message.handle(), ZMQ_SRCFD); }

}  // namespace acus
