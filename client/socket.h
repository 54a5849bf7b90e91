// SPDX-License-Identifier: MIT
// One ZeroMQ socket that is connected to an endpoint, with waits that end at a deadline. Internal to the client
// library.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <zmq.hpp>

namespace acus::client {

class Socket {
 public:
  using Clock = std::chrono::steady_clock;

  // `configure` sets options before the socket connects. Throws ClientError.
  template <class Configure>
  Socket(zmq::socket_type type, std::string endpoint, Configure configure)
      : endpoint_(std::move(endpoint)), context_(1), socket_(context_, type) {
    configure(socket_);
    connect();
  }

  const std::string& endpoint() const { return endpoint_; }
  zmq::socket_t& raw() { return socket_; }

  // Whether the socket can take (ZMQ_POLLOUT) or give (ZMQ_POLLIN) a message before the deadline.
  bool wait(short event, Clock::time_point deadline);

  // Without waiting; false if nobody is connected to take it.
  bool send(std::string_view bytes);

  // Without waiting; the last frame of the next message, or false. The frame stays valid until the next receive.
  bool receive(std::string_view& bytes);

 private:
  void connect();

  std::string endpoint_;
  zmq::context_t context_;
  zmq::socket_t socket_;
  zmq::message_t frame_;
};

}  // namespace acus::client
