// SPDX-License-Identifier: GPL-3.0-or-later
// What goes back to clients through the commands socket: answers, and errors about what cannot be done. A client that
// streams nonsense gets a bounded number of errors a second; all are counted.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>
#include <zmq.hpp>

#include "protocol/codec.h"
#include "server/transport/inbox.h"
#include "server/transport/peers.h"
#include "server/transport/rate_limiter.h"

namespace acus {

// The types of what is always answered.
const std::vector<std::string>& request_types();

class Answers {
 public:
  // Sends through a ROUTER socket; owns neither that nor the peers.
  Answers(zmq::socket_t& commands, const Peers& peers);

  // Lost if the client does not read its answers.
  template <class Message>
  void send(const Sender& sender, const Message& message) {
    protocol::encode(message, bytes_);
    send_bytes(sender);
  }

  void reject(const Sender& sender, const protocol::DecodeError& error);
  template <class Message>
  void reject(const Sender& sender, const Message& message, protocol::ErrorCode code, const std::string& sentence) {
    protocol::DecodeError error(code, sentence);
    error.type = Message::kType;
    error.seq = message.seq;
    reject(sender, error);
  }

  // A line of the log about a client, not more often than anybody could read.
  void log(const Sender& sender, const std::string& what);

  std::uint64_t rejected() const { return rejected_; }

 private:
  void send_bytes(const Sender& sender);

  zmq::socket_t& commands_;
  const Peers& peers_;
  RateLimiter error_limit_, log_limit_;
  std::uint64_t rejected_ = 0;
  std::string bytes_;  // the encoded answer, reused
};

}  // namespace acus
