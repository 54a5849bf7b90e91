// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/connection_monitor.h"

#include <spdlog/spdlog.h>

#include <cstdint>
#include <cstring>

namespace acus {

namespace {

constexpr int kEventsHeard = ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL;
constexpr double kEventLinesPerSecond = 1;

}  // namespace

ConnectionMonitor::ConnectionMonitor(zmq::context_t& context, zmq::socket_t& socket, const std::string& name)
    : events_(context, zmq::socket_type::pair), log_limit_(kEventLinesPerSecond) {
  const std::string endpoint = "inproc://connections/" + name;
  if (zmq_socket_monitor(socket.handle(), endpoint.c_str(), kEventsHeard) != 0) throw zmq::error_t();
  events_.set(zmq::sockopt::rcvhwm, 0);  // at a limit ZeroMQ's own thread would wait for this one
  events_.connect(endpoint);
}

// Two frames: the number of the event (16 bits) and its value (32 bits), then the endpoint.
std::optional<ConnectionChange> ConnectionMonitor::next_change() {
  zmq::message_t event, endpoint;
  while (events_.recv(event, zmq::recv_flags::dontwait)) {
    [[maybe_unused]] const auto received = events_.recv(endpoint, zmq::recv_flags::none);
    std::uint16_t number = 0;
    std::int32_t value = -1;
    std::memcpy(&number, event.data(), sizeof number);
    std::memcpy(&value, event.data<char>() + sizeof number, sizeof value);
    if (number == ZMQ_EVENT_ACCEPTED) {
      open_.insert(value);
      return ConnectionChange{value, true};
    } else if (number == ZMQ_EVENT_DISCONNECTED) {
      open_.erase(value);
      return ConnectionChange{value, false};
    } else {
      log_failure(value);
    }
  }
  return std::nullopt;
}

void ConnectionMonitor::log_failure(std::int32_t reason) {
  if (!log_limit_.allow("", RateLimiter::Clock::now())) return;
  const char* what = "it does not speak ZeroMQ's protocol as this server does";
  if (reason == ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH) what = "one side has keys and the other has none";
  if (reason == ZMQ_PROTOCOL_ERROR_ZMTP_CRYPTOGRAPHIC) what = "it has not the key of this server, but another one";
  spdlog::warn("a connection is refused: {}", what);
}

int connection_of(zmq::message_t& message) { return zmq_msg_get(message.handle(), ZMQ_SRCFD); }

}  // namespace acus
