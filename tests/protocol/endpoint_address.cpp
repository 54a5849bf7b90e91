// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/endpoint_address.h"

#include <doctest/doctest.h>

#include <string>

#include "protocol/messages.h"

namespace acus::protocol::testing {
namespace {

std::string problem(const std::string& endpoint, EndpointUse use) { return problem_with_endpoint(endpoint, use); }

bool listens(const std::string& endpoint) { return problem(endpoint, EndpointUse::listen).empty(); }
bool connects(const std::string& endpoint) { return problem(endpoint, EndpointUse::connect).empty(); }

}  // namespace

TEST_CASE("where other machines can connect is told by the address") {
  for (const std::string local :
       {kDefaultCommandsEndpoint, kDefaultStatesEndpoint, "tcp://127.0.0.1:*", "tcp://127.9.8.7:1", "tcp://localhost:1",
        "tcp://[::1]:65535", "ipc:///run/acus/commands", "ipc://*"}) {
    CAPTURE(local);
    CHECK(is_local_endpoint(local));
  }
  for (const std::string open : {"tcp://*:5750", "tcp://0.0.0.0:5750", "tcp://192.0.2.1:5750", "tcp://eth0:5750",
                                 "tcp://lo:5750", "tcp://128.0.0.1:1", "tcp://127.0.0.1.example.org:1", "tcp://[::]:1",
                                 "tcp://localhost.example.org:1", "nonsense"}) {
    CAPTURE(open);
    CHECK_FALSE(is_local_endpoint(open));
  }
}

TEST_CASE("what programs listen on and connect to is accepted") {
  for (const std::string endpoint :
       {kDefaultCommandsEndpoint, kDefaultStatesEndpoint, "tcp://localhost:1", "tcp://[::1]:65535",
        "ipc:///run/acus/commands", "ipc://relative", "ipc://@name"}) {
    CAPTURE(endpoint);
    CHECK(listens(endpoint));
    CHECK(connects(endpoint));
  }
  for (const std::string endpoint :
       {"tcp://*:5750", "tcp://127.0.0.1:*", "tcp://127.0.0.1:0", "tcp://*:*", "ipc://*"}) {
    CAPTURE(endpoint);
    CHECK(listens(endpoint));
    CHECK_FALSE(connects(endpoint));
  }
  CHECK(is_wildcard_endpoint("tcp://127.0.0.1:*"));
  CHECK(is_wildcard_endpoint("tcp://127.0.0.1:0"));
  CHECK(is_wildcard_endpoint("ipc://*"));
  CHECK_FALSE(is_wildcard_endpoint("tcp://127.0.0.1:10"));
  CHECK_FALSE(is_wildcard_endpoint("ipc://a:*"));
}

TEST_CASE("what means nothing, or something else than it says, is not") {
  for (const std::string endpoint : {"",
                                     "nonsense",
                                     "127.0.0.1:5750",
                                     "tcp:/127.0.0.1:5750",
                                     "inproc://a",
                                     "ws://127.0.0.1:1",
                                     "TCP://127.0.0.1:1",
                                     "tcp://",
                                     "tcp://127.0.0.1",
                                     "tcp://127.0.0.1:",
                                     "tcp://:5750",
                                     "tcp://127.0.0.1:65536",
                                     "tcp://127.0.0.1:99999",
                                     "tcp://127.0.0.1:-1",
                                     "tcp://127.0.0.1:+1",
                                     "tcp://127.0.0.1: 1",
                                     "tcp://127.0.0.1:1x",
                                     "tcp://127.0.0.1:0x10",
                                     "tcp://127.0.0.1:99999999999999999999",
                                     "ipc://",
                                     "ipc://@"}) {
    CAPTURE(endpoint);
    CHECK_FALSE(listens(endpoint));
    CHECK_FALSE(connects(endpoint));
  }
  CHECK_FALSE(listens(std::string("ipc://a\0b", 9)));
}

TEST_CASE("the length of a path is what the system allows") {
  CHECK(listens("ipc://" + std::string(107, 'x')));
  CHECK(problem("ipc://" + std::string(108, 'x'), EndpointUse::listen) ==
        "expected a path of at most 107 bytes, found 108; choose a shorter one");
}

TEST_CASE("a bad port is named") {
  CHECK(problem("tcp://127.0.0.1:99999", EndpointUse::listen) ==
        "expected a port from 0 to 65535, or * for a free one, found '99999'");
  CHECK(problem("tcp://127.0.0.1:*", EndpointUse::connect) == "expected a port from 1 to 65535, found '*'");
}

}  // namespace acus::protocol::testing
