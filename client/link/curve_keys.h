// SPDX-License-Identifier: MIT
// Keys with which a client and its server know each other.
#pragma once

#include <string>

#include "protocol/key_file.h"

namespace acus::client {

// For a server that admits clients by their keys; protocol/key_file.h reads them from files.
struct CurveKeys {
  std::string server;     // the server's public key
  protocol::KeyPair own;  // the client's, whose public key the server knows
};

}  // namespace acus::client
