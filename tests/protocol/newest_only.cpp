// SPDX-License-Identifier: GPL-3.0-or-later
// What protocol/README.md says of "newest only": of two-frame messages that wait, the last.
#include <doctest/doctest.h>

#include <optional>
#include <string>
#include <utility>
#include <zmq.hpp>

namespace acus::protocol {
namespace {

std::optional<zmq::message_t> newest(zmq::socket_t& states) {
  std::optional<zmq::message_t> payload;
  zmq::message_t topic, next;
  while (states.recv(topic, zmq::recv_flags::dontwait) && states.recv(next)) payload = std::move(next);
  return payload;
}

}  // namespace

TEST_CASE("of the states that wait, the newest is read") {
  zmq::context_t context;
  zmq::socket_t server(context, zmq::socket_type::pair), states(context, zmq::socket_type::pair);  // which loses none
  server.bind("inproc://states");
  states.connect("inproc://states");
  CHECK_FALSE(newest(states));
  for (int i = 0; i < 100; ++i) {
    server.send(zmq::str_buffer("force"), zmq::send_flags::sndmore);
    server.send(zmq::buffer(std::to_string(i)));
  }
  CHECK(newest(states).value().to_string() == "99");
  CHECK_FALSE(newest(states));
}

}  // namespace acus::protocol
