// SPDX-License-Identifier: GPL-3.0-or-later
// Who is at the other end of the connections to the commands socket, for the log: address and public key, or process
// and user of this machine. A client chooses its routing id, but not these.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "protocol/key_file.h"
#include "server/transport/inbox.h"
#include "server/transport/rate_limiter.h"

namespace acus {

class Peers {
 public:
  // `keys`: of the clients that are admitted, with their names; empty without keys.
  explicit Peers(std::vector<protocol::PublicKey> keys);

  // Makes known, and logs, by whom a message came that is the first of its connection.
  void note(const Arrived& message);
  // Logs that a connection has ended.
  void forget(int connection);

  // "127.0.0.1 with the key of 'alice'"; "nobody known" for a connection without a message.
  std::string who(int connection) const;

 private:
  struct Peer {
    std::string client, who;
  };
  std::string describe(const Arrived& message) const;
  void log(const Peer& peer, const char* what);

  const std::vector<protocol::PublicKey> keys_;
  std::map<int, Peer> peers_;  // by connection
  RateLimiter log_limit_;
  std::uint64_t unlogged_ = 0;
};

// Of a routing frame, for the log.
std::string shown(const std::string& client);

}  // namespace acus
