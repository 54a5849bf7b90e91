// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/inbox.h"

#include <doctest/doctest.h>

#include <vector>

namespace acus {
namespace {

// A server's socket, an inbox on it, and a client, which all speak within the process.
struct Pair {
  zmq::context_t context;
  zmq::socket_t server{context, zmq::socket_type::router}, client{context, zmq::socket_type::dealer};
  Inbox inbox{server};

  Pair() {
    server.bind("inproc://inbox");
    client.connect("inproc://inbox");
  }

  void send(const std::vector<std::string>& frames) {
    for (std::size_t i = 0; i < frames.size(); ++i)
      client.send(zmq::buffer(frames[i]), i + 1 < frames.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
  }
};

Arrived message_of(const std::string& client, const std::string& bytes, int connection = 1) {
  return {{.identity = client, .connection = connection}, true, zmq::message_t(bytes)};
}

}  // namespace

TEST_CASE("a message is one frame, or an empty one and one more; others are told apart") {
  Pair pair;
  CHECK_FALSE(pair.inbox.receive());
  struct Case {
    std::vector<std::string> frames;
    bool framed, delimited;
  };
  for (const Case& each : std::vector<Case>{{{"payload"}, true, false},
                                            {{"", "payload"}, true, true},
                                            {{""}, true, false},
                                            {{"", ""}, true, true},
                                            {{"one", "payload"}, false, false},
                                            {{"", "", "payload"}, false, true}}) {
    pair.send(each.frames);
    const std::optional<Arrived> message = pair.inbox.receive();
    REQUIRE(message);
    CHECK(message->framed == each.framed);
    CHECK(message->sender.delimited == each.delimited);
    CHECK(message->bytes() == each.frames.back());
    CHECK_FALSE(message->sender.identity.empty());
  }
  CHECK_FALSE(pair.inbox.receive());
}

TEST_CASE("a message of very many frames takes many turns, and the next one comes after it") {
  Pair pair;
  pair.send(std::vector<std::string>(100'000, ""));
  pair.send({"next"});
  int turns = 0;
  std::optional<Arrived> message;
  while (!(message = pair.inbox.receive())) REQUIRE(++turns < 100'000);
  CHECK(turns > 10);
  CHECK_FALSE(message->framed);
  message = pair.inbox.receive();
  REQUIRE(message);
  CHECK(message->framed);
  CHECK(message->bytes() == "next");
}

TEST_CASE("messages that wait keep their order and know whose they are") {
  Pair pair;
  CHECK_FALSE(pair.inbox.take_waiting());
  for (const char* bytes : {"first", "second", "third"}) pair.inbox.put_aside(message_of(bytes, bytes));
  CHECK(pair.inbox.has_waiting_of("second"));
  CHECK_FALSE(pair.inbox.has_waiting_of("fourth"));
  for (const char* bytes : {"first", "second", "third"}) CHECK(pair.inbox.take_waiting()->bytes() == bytes);
  CHECK_FALSE(pair.inbox.has_waiting());
  CHECK_FALSE(pair.inbox.has_waiting_of("second"));
}

TEST_CASE("there is room for a number of messages, and of bytes") {
  Pair pair;
  int count = 0;
  while (!pair.inbox.full()) pair.inbox.put_aside(message_of("a", "x")), ++count;
  CHECK(count == 1024);
  for (; pair.inbox.take_waiting(); --count) CHECK(count > 0);
  for (; !pair.inbox.full(); ++count) pair.inbox.put_aside(message_of("a", std::string(1 << 20, 'x')));
  CHECK(count == 4);
  while (pair.inbox.take_waiting()) continue;
  CHECK_FALSE(pair.inbox.full());
}

TEST_CASE("what waits of a connection that has ended is not taken for that of the next one with its number") {
  Pair pair;
  pair.inbox.put_aside(message_of("a", "x", 7));
  pair.inbox.put_aside(message_of("b", "y", 8));
  pair.inbox.forget_connection(7);
  CHECK(pair.inbox.take_waiting()->sender.connection == -1);
  CHECK(pair.inbox.take_waiting()->sender.connection == 8);
}

}  // namespace acus
