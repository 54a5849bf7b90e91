// SPDX-License-Identifier: MIT
#include "client/socket.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "client/client.h"

namespace acus::client {
namespace {

constexpr const char* kMonitorEndpoint = "inproc://monitor";

}  // namespace

void Socket::connect() {
  try {
    if (zmq_socket_monitor(socket_.handle(), kMonitorEndpoint,
                           ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_DISCONNECTED)) {
      throw zmq::error_t();
    }
    monitor_.connect(kMonitorEndpoint);
    socket_.connect(endpoint_);
  } catch (const zmq::error_t& error) {
    throw ClientError("endpoint '" + endpoint_ + "': " + error.what() +
                      "; expected one that ZeroMQ can connect to, such as " + protocol::kDefaultCommandsEndpoint);
  }
}

// An event is two frames: its 16-bit number with a value, and the address.
bool Socket::connected() {
  zmq::message_t event;
  zmq::message_t address;
  while (monitor_.recv(event, zmq::recv_flags::dontwait) && monitor_.recv(address, zmq::recv_flags::dontwait)) {
    std::uint16_t number = 0;
    std::memcpy(&number, event.data(), std::min(sizeof number, event.size()));
    connected_ = number == ZMQ_EVENT_HANDSHAKE_SUCCEEDED;
  }
  return connected_;
}

// Returns at the deadline, or early when one of the sockets has something or a signal came.
void Socket::wait(std::span<zmq::pollitem_t> items, Clock::time_point deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
  const int ready = zmq_poll(items.data(), static_cast<int>(items.size()), static_cast<long>(std::max<long>(left, 0)));
  if (ready < 0 && zmq_errno() != EINTR)
    throw ClientError("endpoint '" + endpoint_ + "': " + zmq_strerror(zmq_errno()));
}

bool Socket::wait_for_peer(Clock::time_point deadline) {
  std::array<zmq::pollitem_t, 1> items{{{monitor_.handle(), 0, ZMQ_POLLIN, 0}}};
  while (!connected() && Clock::now() < deadline) wait(items, deadline);
  return connected_;
}

bool Socket::wait_for_message(Clock::time_point deadline, bool while_connected) {
  std::array<zmq::pollitem_t, 2> items{{{socket_.handle(), 0, ZMQ_POLLIN, 0}, {monitor_.handle(), 0, ZMQ_POLLIN, 0}}};
  while (!has_message()) {
    if (Clock::now() >= deadline) return false;
    if (!connected() && while_connected) return has_message();  // one may have come right before the end
    wait(items, deadline);
  }
  return true;
}

bool Socket::send(std::string_view bytes) {
  return socket_.send(zmq::buffer(bytes), zmq::send_flags::dontwait).has_value();
}

bool Socket::receive(std::string_view& bytes) {
  if (!socket_.recv(frame_, zmq::recv_flags::dontwait)) return false;
  while (frame_.more()) {  // the frames of one message arrive together; ZeroMQ bounds them
    if (!socket_.recv(frame_, zmq::recv_flags::dontwait)) return false;
  }
  bytes = {frame_.data<char>(), frame_.size()};
  return true;
}

}  // namespace acus::client
