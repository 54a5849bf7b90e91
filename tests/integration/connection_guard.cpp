// SPDX-License-Identifier: GPL-3.0-or-later
// Over TCP, what a client leaves in the server's memory is bounded, and who goes beyond it loses the connection.
#include <doctest/doctest.h>

#include <deque>
#include <fstream>
#include <map>

#include "tests/integration/raw_peer.h"
#include "tests/integration/tcp_server.h"

namespace acus::testing {
namespace {

std::string frame_with_more(const std::string& body) {
  std::string header{'\3'};
  for (int shift = 56; shift >= 0; shift -= 8) header += static_cast<char>(body.size() >> shift & 0xff);
  return header + body;
}

}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // whose memory grows by itself

namespace {

// The largest memory that the process has had so far (kB).
long peak_memory(Process& process) {
  std::ifstream status("/proc/" + std::to_string(process.id()) + "/status");
  for (std::string word; status >> word;) {
    long value = 0;
    if (word == "VmHWM:" && status >> value) return value;
  }
  FAIL("the server is gone");
  return 0;
}

std::string many(const std::string& bytes, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += bytes;
  return all;
}

// Sends the bytes again and again until the connection is closed; false if it still is open after `most` bytes.
bool is_cut(RawPeer& peer, const std::string& bytes, std::size_t most) {
  for (std::size_t sent = 0; sent < most; sent += bytes.size())
    if (!peer.send(bytes)) return true;
  return false;
}

}  // namespace

TEST_CASE("a message that never ends loses its connection, and memory has a bound, however often it is tried") {
  TcpServer server;
  client::CommandLink other(server.commands());
  other.acquire({"needle"}, kPatience);
  const long before = peak_memory(server.process());
  const std::string megabyte = frame_with_more(std::string(1 << 20, 'x')),
                    nothing = many(std::string{'\1', '\0'}, 1 << 16);
  for (const std::string& frames : {megabyte, nothing, megabyte, nothing}) {
    RawPeer endless(server.commands());
    endless.shake_hands("DEALER");
    CHECK(is_cut(endless, frames, std::size_t{20} << 30));
    CHECK(other.hello(kPatience).held == std::vector<std::string>{"needle"});
  }
  CHECK(peak_memory(server.process()) - before < 1'300'000);
}

TEST_CASE("what a frame claims to have takes no memory before it has come, in a handshake or after it") {
  TcpServer server;
  client::CommandLink other(server.commands());
  other.hello(kPatience);
  const long before = peak_memory(server.process());
  const auto claim = [](char flags) {
    return flags + std::string("\0\0\0\0\1\xff\xff\xff", 8) + std::string(8000, 'x');
  };
  std::deque<RawPeer> peers;  // 32 MiB each
  for (int i = 0; i < 60; ++i) {
    RawPeer& peer = peers.emplace_back(server.commands());
    if (i % 2 == 0) {
      peer.shake_hands("DEALER");
      CHECK(peer.send(claim('\2')));
    } else {
      CHECK(peer.send(zmtp3_greeting("NULL") + claim('\6')));
    }
  }
  for (int i = 0; i < 3; ++i) other.hello(kPatience);
  const long each = (peak_memory(server.process()) - before) / static_cast<long>(peers.size());
  CHECK(each < 100);  // kB; 32,768 if it were set aside and locked
}

#endif

TEST_CASE("a message as large as may be, and one of many frames, keep their connection") {
  TcpServer server;
  RawPeer peer(server.commands());
  peer.shake_hands("DEALER");
  const std::string megabyte(1 << 20, 'x');
  for (const auto& [frame, count] : std::map<std::string, int>{{megabyte, 31}, {std::string(), 200'000}}) {
    for (int i = 0; i < count; ++i) REQUIRE(peer.send(frame_with_more(frame)));
    peer.send_frame("end");
    CHECK(peer.receive_message().find("invalid_msgpack") != std::string::npos);
  }
}

TEST_CASE("who subscribes without end loses the connection, and others go on") {
  TcpServer server;
  client::StateLink states(server.states());
  states.subscribe("force");
  receive<protocol::Force>(states);
  RawPeer greedy(server.states());
  greedy.shake_hands("SUB");
  const auto subscription = [](int number) {
    std::string topic = "\1" + std::to_string(number);
    topic.resize(200, 'x');
    return std::string{'\0', static_cast<char>(topic.size())} + topic;
  };
  bool cut = false;
  for (int i = 0; i < 100'000 && !cut; ++i) cut = !greedy.send(subscription(i));
  CHECK(cut);
  receive<protocol::Force>(states);
}

}  // namespace acus::testing
