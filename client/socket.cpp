// SPDX-License-Identifier: MIT
#include "client/socket.h"

#include <algorithm>
#include <cerrno>

#include "client/client.h"

namespace acus::client {

void Socket::connect() {
  try {
    socket_.connect(endpoint_);
  } catch (const zmq::error_t& error) {
    throw ClientError("endpoint '" + endpoint_ + "': " + error.what() +
                      "; expected one that ZeroMQ can connect to, such as " + protocol::kDefaultCommandsEndpoint);
  }
}

bool Socket::wait(short event, Clock::time_point deadline) {
  for (;;) {  // bounded by the deadline; it turns only for signals
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    zmq::pollitem_t item{socket_.handle(), 0, event, 0};
    const auto milliseconds = std::max<std::chrono::milliseconds::rep>(left.count(), 0);
    if (zmq_poll(&item, 1, static_cast<long>(milliseconds)) >= 0) return (item.revents & event) != 0;
    if (zmq_errno() != EINTR) throw ClientError("endpoint '" + endpoint_ + "': " + zmq_strerror(zmq_errno()));
    if (milliseconds == 0) return false;
  }
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
