// SPDX-License-Identifier: MIT
#include "client/link/socket.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "client/link/errors.h"

namespace acus::client {
namespace {

constexpr const char* kMonitorEndpoint = "inproc://monitor";
constexpr int kEvents = ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL |
                        ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH | ZMQ_EVENT_DISCONNECTED;

}  // namespace

void Socket::set_keys(const CurveKeys& keys) {
  try {
    socket_.set(zmq::sockopt::curve_serverkey, keys.server);
    socket_.set(zmq::sockopt::curve_publickey, keys.own.public_key);
    socket_.set(zmq::sockopt::curve_secretkey, keys.own.secret_key);
  } catch (const zmq::error_t&) {
    throw ClientError(
        "endpoint '" + endpoint_ +
        "': ZeroMQ does not accept the keys; expected 40 characters of Z85 each, and a ZeroMQ with CURVE");
  }
}

void Socket::connect() {
  try {
    if (zmq_socket_monitor(socket_.handle(), kMonitorEndpoint, kEvents)) throw zmq::error_t();
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
    std::uint32_t value = 0;
    if (event.size() < sizeof number + sizeof value) continue;
    std::memcpy(&number, event.data(), sizeof number);
    std::memcpy(&value, event.data<char>() + sizeof number, sizeof value);
    take_event(number, value);
  }
  return connected_;
}

void Socket::take_event(std::uint16_t number, std::uint32_t value) {
  connected_ = number == ZMQ_EVENT_HANDSHAKE_SUCCEEDED;
  failure_ = connected_ ? Failure::none : std::max(failure_, failure_of(number, value));
}

// Each attempt to connect may end in another way, as the other side may close first: the one that says most counts.
Socket::Failure Socket::failure_of(std::uint16_t number, std::uint32_t value) {
  switch (number) {
    case ZMQ_EVENT_HANDSHAKE_FAILED_AUTH:
      return Failure::refused;
    case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL:
      return value == ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH ? Failure::other_mechanism : Failure::broken_off;
    case ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL:
      return Failure::broken_off;
    default:
      return Failure::none;
  }
}

std::string Socket::why_no_peer() const {
  switch (failure_) {
    case Failure::none:
      return "nobody is there";
    case Failure::refused:
      return "the server refuses this client's key; its public key has to be among those of the server's "
             "--curve-clients";
    case Failure::other_mechanism:
      return keyed_ ? "the server does not use keys; connect without them, or start it with --curve-server-key"
                    : "the server admits only clients with keys; give the server's public key and this client's own";
    case Failure::broken_off:
      return keyed_
                 ? "the connection ended in the handshake; perhaps the server's public key given here is not that of "
                   "this server"
                 : "the connection ended in the handshake; perhaps the server admits only clients with keys or has "
                   "as many connections as it may, or somebody else than an acus-server listens there";
  }
  return {};
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
