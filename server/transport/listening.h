// SPDX-License-Identifier: GPL-3.0-or-later
// How a socket of the server begins to listen: whom it hears, what it must not take over, and what is said if it
// cannot.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "protocol/key_file.h"

namespace acus {

// what() names the option, the endpoint, what is in the way, and the remedy.
struct CannotListen : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The server's key, and those of the clients that it admits: everybody else is refused.
struct CurveServer {
  protocol::KeyPair key;
  std::vector<protocol::PublicKey> clients;
};

struct Admission {
  std::optional<CurveServer> curve;  // without it, whoever can connect is admitted,
  bool insecure = false;             // from other machines, too, if this says so
};

// Binds the socket to the endpoint that the command line's `option` gives. Only peers that speak ZMTP 3 are heard. An
// ipc endpoint takes the place of a socket that nobody listens on any more, and of nothing else. With keys there has to
// be a ZapHandler already: without one ZeroMQ asks nobody and admits everybody. Throws CannotListen, also for an
// endpoint that other machines can reach if `admission` does not allow it.
void listen(zmq::socket_t& socket, const std::string& option, const std::string& endpoint, const Admission& admission);

}  // namespace acus
