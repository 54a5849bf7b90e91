// SPDX-License-Identifier: GPL-3.0-or-later
// How a socket of the server begins to listen: whom it hears, what it must not take over, and what is said if it
// cannot.
#pragma once

#include <stdexcept>
#include <string>
#include <zmq.hpp>

namespace acus {

// what() names the option, the endpoint, what is in the way, and the remedy.
struct CannotListen : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Binds the socket to the endpoint that the command line's `option` gives. Only peers that speak ZMTP 3 are heard. An
// ipc endpoint takes the place of a socket that nobody listens on any more, and of nothing else. Throws CannotListen.
void listen(zmq::socket_t& socket, const std::string& option, const std::string& endpoint);

}  // namespace acus
