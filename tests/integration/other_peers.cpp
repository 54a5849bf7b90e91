// SPDX-License-Identifier: GPL-3.0-or-later
// What reaches the sockets and is no client: web pages, peers of before ZMTP 3, and bytes of any kind.
#include <doctest/doctest.h>

#include <random>

#include "tests/integration/raw_peer.h"
#include "tests/integration/server_process.h"

namespace acus::testing {
namespace {

const std::string kShutdown = encode(protocol::Shutdown{});

// What must not be heard, each with a request to end at a place where ZeroMQ would read a message.
std::vector<std::string> commanding_bytes() {
  return {web_page_post(zmtp1_frame(kShutdown)), zmtp1_greeting() + zmtp1_frame(kShutdown),
          zmtp2_greeting('\5') + std::string{'\0', static_cast<char>(kShutdown.size())} + kShutdown};
}

}  // namespace

TEST_CASE("a web page and peers of before ZMTP 3 are not heard on the commands socket") {
  ServerProcess server;
  for (const std::string& bytes : commanding_bytes()) {
    RawPeer peer(server.commands());
    peer.send(bytes);
    CHECK(peer.is_closed());
  }
  client::CommandLink commands(server.commands());
  REQUIRE(commands.hello(kPatience).scene == "small");
  client::StateLink states = subscribe(server, {});
  CHECK(receive<protocol::Stats>(states).rejected == 0);
}

TEST_CASE("a web page and peers of before ZMTP 3 get no states") {
  ServerProcess server;
  const std::string subscription = zmtp1_frame("\1force");
  for (const std::string& bytes : {web_page_post(subscription), zmtp1_greeting() + subscription,
                                   zmtp2_greeting('\2') + std::string("\0\6\1force", 8)}) {
    RawPeer peer(server.states());
    peer.send(bytes);
    CHECK(peer.is_closed());
  }
  client::StateLink states = subscribe(server, {});
  CHECK(receive<protocol::Stats>(states).subscribed == std::vector<std::string>{"stats"});
}

TEST_CASE("bytes of any kind reach nobody and end nothing") {
  ServerProcess server;
  std::mt19937 random(11);
  for (int i = 0; i < 200; ++i) {
    const std::string& endpoint = i % 2 ? server.commands() : server.states();
    RawPeer peer(endpoint);
    std::string bytes;
    for (std::size_t size = random() % 300; size > 0; --size) bytes += static_cast<char>(random() % 256);
    if (i % 3 == 0) bytes = "\xff" + std::string(8, '\0') + "\x7f\3" + bytes;
    peer.send(bytes);
  }
  client::CommandLink commands(server.commands());
  REQUIRE(commands.hello(kPatience).scene == "small");
  client::StateLink states = subscribe(server, {});
  CHECK(receive<protocol::Stats>(states).rejected == 0);
}

TEST_CASE("a peer that writes ZMTP 3 by hand is a client like others") {
  ServerProcess server;
  RawPeer peer(server.commands());
  peer.shake_hands("DEALER");
  protocol::Hello hello;
  hello.seq = 7;
  peer.send_frame(encode(hello));
  const protocol::Reply reply = protocol::decode_reply(peer.receive_message());
  CHECK(std::get<protocol::HelloReply>(reply).seq == 7);
}

}  // namespace acus::testing
