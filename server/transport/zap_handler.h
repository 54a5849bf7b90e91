// SPDX-License-Identifier: GPL-3.0-or-later
// Says which clients the sockets of a context admit: those whose public keys are known. ZeroMQ asks it once a client
// has proved that it has the secret key (ZAP, rfc.zeromq.org/spec/27).
#pragma once

#include <cstdint>
#include <string>
#include <unordered_set>
#include <vector>
#include <zmq.hpp>

#include "protocol/key_file.h"
#include "server/transport/rate_limiter.h"

namespace acus {

class ZapHandler {
 public:
  // To be made before the sockets listen: where there is none, ZeroMQ admits whoever has any keys.
  ZapHandler(zmq::context_t& context, const std::vector<protocol::PublicKey>& clients);

  zmq::socket_t& socket() { return socket_; }  // readable when ZeroMQ asks
  void answer();                               // what was asked so far; does not wait

 private:
  bool answer_one();
  bool admits(const std::string& mechanism, const std::string& key) const;
  void log_refusal(const std::string& address, const std::string& key);

  zmq::socket_t socket_;
  std::unordered_set<std::string> clients_;  // their public keys
  RateLimiter log_limit_;
  std::uint64_t refused_ = 0;  // since the last line of the log
};

}  // namespace acus
