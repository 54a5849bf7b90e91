// SPDX-License-Identifier: MIT
// One ZeroMQ socket that connects to an endpoint, knows whether a peer is there, and waits no longer than a deadline.
// Internal to the client library.
//
// ZMQ_IMMEDIATE would tell about the peer as well, but drops answers that came in right before the peer closed.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <zmq.hpp>

#include "client/link/curve_keys.h"

namespace acus::client {

class Socket {
 public:
  using Clock = std::chrono::steady_clock;

  // `configure` sets options before the socket connects. Throws ClientError.
  template <class Configure>
  Socket(zmq::socket_type type, std::string endpoint, const std::optional<CurveKeys>& keys, Configure configure)
      : endpoint_(std::move(endpoint)),
        keyed_(keys.has_value()),
        socket_(context_, type),
        monitor_(context_, zmq::socket_type::pair) {
    configure(socket_);
    if (keys) set_keys(*keys);
    connect();
  }

  const std::string& endpoint() const { return endpoint_; }
  zmq::socket_t& raw() { return socket_; }

  // Whether a peer has completed ZeroMQ's handshake and not gone away since.
  bool connected();

  // After no peer was there: what may be wrong, as far as the attempts to connect tell.
  std::string why_no_peer() const;

  // False if no peer was there until the deadline.
  bool wait_for_peer(Clock::time_point deadline);

  // False if no message came until the deadline or, with `while_connected`, until the peer went away.
  bool wait_for_message(Clock::time_point deadline, bool while_connected);

  // Without waiting; false if the queue to the peer is full.
  bool send(std::string_view bytes);

  // Without waiting; the last frame of the next message, or false. The frame stays valid until the next receive.
  bool receive(std::string_view& bytes);

 private:
  enum class Failure { none, broken_off, other_mechanism, refused };  // from what says least to what says most

  void set_keys(const CurveKeys& keys);
  void connect();
  void take_event(std::uint16_t number, std::uint32_t value);
  static Failure failure_of(std::uint16_t number, std::uint32_t value);
  void wait(std::span<zmq::pollitem_t> items, Clock::time_point deadline);
  bool has_message() { return (socket_.get(zmq::sockopt::events) & ZMQ_POLLIN) != 0; }

  std::string endpoint_;
  bool keyed_;
  zmq::context_t context_;
  zmq::socket_t socket_;
  zmq::socket_t monitor_;  // events of socket_
  zmq::message_t frame_;
  bool connected_ = false;
  Failure failure_ = Failure::none;  // of the handshakes since the last that succeeded
};

}  // namespace acus::client
