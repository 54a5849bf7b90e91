// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/listening.h"

namespace acus {
namespace {

// Any name will do. With a domain and no ZAP handler, ZeroMQ accepts every peer that speaks ZMTP 3, and closes the
// connections of those before it. ZMTP 1.0 has no greeting: bytes of any origin are frames, a web page's POST included.
constexpr const char* kZapDomain = "acus";

}  // namespace

void listen(zmq::socket_t& socket, const std::string& option, const std::string& endpoint) {
  socket.set(zmq::sockopt::zap_domain, std::string(kZapDomain));
  try {
    socket.bind(endpoint);
  } catch (const zmq::error_t& error) {
    throw CannotListen("cannot listen on " + option + " '" + endpoint + "': " + error.what());
  }
}

}  // namespace acus
