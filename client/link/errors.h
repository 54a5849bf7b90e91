// SPDX-License-Identifier: MIT
// What can go wrong on a link to a server.
#pragma once

#include <stdexcept>

#include "protocol/messages.h"

namespace acus::client {

// Any trouble with the link; what() names the endpoint and what happened.
struct ClientError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Nobody answered in time: there is no server at the endpoint, or it went away.
struct Vanished : ClientError {
  using ClientError::ClientError;
};

// Somebody answered, but does not speak this version of the protocol.
struct ProtocolMismatch : ClientError {
  using ClientError::ClientError;
};

// The server rejected a message.
struct Refused : ClientError {
  explicit Refused(const protocol::Error& rejection);
  protocol::Error error;
};

}  // namespace acus::client
