// SPDX-License-Identifier: MIT
// The endpoints that people give to programs: tcp://HOST:PORT and ipc://PATH. ZeroMQ accepts some that mean something
// else than what is written: it takes a port modulo 65536.
#pragma once

#include <string>
#include <string_view>

namespace acus::protocol {

// Listening also takes * for the host (every interface), for the port (a free one, as 0 does) and for the path (in a
// new folder).
enum class EndpointUse { listen, connect };

// What is wrong with the endpoint: what was expected and what was found; empty if nothing is. Whether the host or the
// folder exists is not looked at.
std::string problem_with_endpoint(std::string_view endpoint, EndpointUse use);

// Whether the endpoint, given twice, would be two different ones.
bool is_wildcard_endpoint(std::string_view endpoint);

// Whether nobody but programs of this machine can connect to who listens there.
bool is_local_endpoint(std::string_view endpoint);

}  // namespace acus::protocol
