// SPDX-License-Identifier: GPL-3.0-or-later
// What one client does too much of costs the others nothing that they cannot do without. How much time it costs is
// measured by tests/study/flood.
#include <doctest/doctest.h>
#include <sys/resource.h>

#include <atomic>
#include <deque>
#include <map>
#include <thread>
#include <zmq.hpp>

#include "tests/integration/raw_peer.h"
#include "tests/integration/server_process.h"

namespace acus::testing {
namespace {

// A client that sends bytes as they are.
class RawClient {
 public:
  explicit RawClient(const ServerProcess& server) : socket_(context_, zmq::socket_type::dealer) {
    socket_.set(zmq::sockopt::linger, 0);
    socket_.set(zmq::sockopt::sndhwm, 1);
    socket_.set(zmq::sockopt::rcvtimeo, static_cast<int>(kPatience.count()));
    socket_.connect(server.commands());
  }

  bool try_to_send(const std::string& bytes, std::chrono::milliseconds timeout) {
    socket_.set(zmq::sockopt::sndtimeo, static_cast<int>(timeout.count()));
    return socket_.send(zmq::buffer(bytes), zmq::send_flags::none).has_value();
  }
  void send(const std::string& bytes, zmq::send_flags flags = zmq::send_flags::none) {
    socket_.set(zmq::sockopt::sndtimeo, static_cast<int>(kPatience.count()));
    REQUIRE(socket_.send(zmq::buffer(bytes), flags));
  }
  protocol::Reply receive() {
    zmq::message_t message;
    REQUIRE(socket_.recv(message));
    return protocol::decode_reply(message.to_string_view());
  }

 private:
  zmq::context_t context_;
  zmq::socket_t socket_;
};

template <class Request>
std::string request(std::uint64_t seq) {
  Request message;
  message.seq = seq;
  return encode(message);
}

// Sends the same messages again and again, as fast as the server takes them, until it goes out of scope.
class Flood {
 public:
  Flood(const ServerProcess& server, std::vector<std::string> messages)
      : thread_([this, &server, messages = std::move(messages)] {
          RawClient client(server);
          while (!stop_)
            for (const std::string& bytes : messages) client.try_to_send(bytes, 10ms);
        }) {}
  ~Flood() {
    stop_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

// What programs that this one starts may open, until it goes out of scope.
class OpenFiles {
 public:
  explicit OpenFiles(rlim_t soft_limit) {
    getrlimit(RLIMIT_NOFILE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = soft_limit;
    REQUIRE(setrlimit(RLIMIT_NOFILE, &limit) == 0);
  }
  ~OpenFiles() { setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_;
};

}  // namespace

TEST_CASE("while one client floods the server, another's commands take effect and no tick is missing" *
          doctest::test_suite("clock")) {
  ServerProcess server;
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  const Flood poses(server, {encode(pose_at(0.4, 1))}), requests(server, {request<protocol::Hello>(1)}),
      costly(server, {request<protocol::Describe>(1), request<protocol::Snapshot>(2), request<protocol::Hash>(3)}),
      nonsense(server, {std::string(100'000, '\x91'), "", std::string(1 << 20, 'x')});
  protocol::Force last = receive<protocol::Force>(states);
  for (std::uint64_t i = 1; i <= 100; ++i) {
    REQUIRE(commands.send(pose_at(0.5, i)));
    const protocol::Force force = receive<protocol::Force>(states);
    CHECK(force.tick == last.tick + 1);
    last = force;
  }
  while (last.seq != 100) last = receive<protocol::Force>(states);
  CHECK(commands.hello(kPatience).scene == "small");
  CHECK(commands.reset(kPatience).epoch == 1);
}

TEST_CASE("who asks for too much is told so, and others are not") {
  ServerProcess server;
  RawClient greedy(server);
  std::map<std::string, int> answers;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    greedy.send(request<protocol::Reset>(i));
    const protocol::Reply reply = greedy.receive();
    const auto* error = std::get_if<protocol::Error>(&reply);
    ++answers[error ? name_of(error->code) : "done"];
  }
  CHECK(answers["done"] >= 20);
  CHECK(answers["busy"] > 0);
  CHECK(answers["done"] + answers["busy"] == 1000);
  client::CommandLink modest(server.commands());
  modest.reset(kPatience);
  modest.describe(kPatience);
}

TEST_CASE("in lockstep nobody is told that it asks too often") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands(server.commands());
  for (std::uint64_t epoch = 1; epoch <= 100; ++epoch) REQUIRE(commands.reset(kPatience).epoch == epoch);
}

TEST_CASE("while a long step runs, others are told who is there, and wait for everything else in their order") {
  ServerProcess server({"--lockstep"});
  RawClient other(server);
  client::CommandLink third(server.commands());
  third.hello(kPatience);
  {
    client::CommandLink commands(server.commands());
    CHECK_THROWS_AS(commands.step(100'000, 50ms), client::Vanished);
    CHECK(third.hello(kPatience).lockstep);
    third.describe(kPatience);
    other.send(request<protocol::Hello>(1));
    CHECK(std::get<protocol::HelloReply>(other.receive()).seq == 1);
    other.send(request<protocol::Hash>(2));
    other.send(request<protocol::Hello>(3));
    third.hello(kPatience);
  }
  const auto reply = std::get<protocol::HashReply>(other.receive());
  CHECK(reply.seq == 2);
  CHECK(reply.tick > 0);
  CHECK(reply.tick < 100'000);
  CHECK(std::get<protocol::HelloReply>(other.receive()).seq == 3);
}

TEST_CASE("a lockstep server that is busy takes a bounded number of large messages in") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands(server.commands());
  commands.hello(kPatience);
  CHECK_THROWS_AS(commands.step(100'000, 50ms), client::Vanished);
  RawClient greedy(server);
  int sent = 0;
  while (sent < 200 && greedy.try_to_send(std::string(4 << 20, 'x'), 1000ms)) ++sent;
  CHECK(sent < 100);
}

TEST_CASE("idle connections lock nobody out, as long as the system permits more") {
  std::optional<ServerProcess> server;
  {
    const OpenFiles few(64);
    server.emplace();
    client::CommandLink(server->commands()).hello(kPatience);
  }
  std::deque<RawPeer> idle;
  for (int i = 0; i < 100; ++i) idle.emplace_back(server->commands());
  CHECK(client::CommandLink(server->commands()).hello(kPatience).scene == "small");
}

TEST_CASE("a message of very many frames is refused, and nobody else waits for its end") {
  ServerProcess server;
  client::StateLink states = subscribe(server, {"force"});
  RawClient client(server);
  client.send("begin", zmq::send_flags::sndmore);
  for (int i = 0; i < 300'000; ++i) client.send("", zmq::send_flags::sndmore);
  client.send("end");
  CHECK(std::get<protocol::Error>(client.receive()).code == protocol::ErrorCode::invalid_msgpack);
  client.send(request<protocol::Hello>(1));
  CHECK(std::get<protocol::HelloReply>(client.receive()).seq == 1);
  receive<protocol::Force>(states);
}

TEST_CASE("that a subscriber loses states is counted" * doctest::test_suite("clock")) {
  ServerProcess server({"--rate", "5000"});
  client::StateLink states = subscribe(server, {});
  CHECK(receive<protocol::Stats>(states).dropped == 0);
  RawPeer stalled(server.states());
  stalled.shake_hands("SUB");
  stalled.send_frame("\1force");
  const auto deadline = std::chrono::steady_clock::now() + 2 * kPatience;
  std::uint64_t dropped = 0;
  while (dropped == 0 && std::chrono::steady_clock::now() < deadline)
    dropped = receive<protocol::Stats>(states).dropped;
  CHECK(dropped > 0);
}

TEST_CASE("a subscription that no topic could have closes its connection") {
  ServerProcess server;
  client::StateLink states = subscribe(server, {"force"});
  RawPeer peer(server.states());
  peer.shake_hands("SUB");
  for (int i = 0; i < 2; ++i) peer.send(std::string("\2\0\0\0\0\0\0\4\0\1", 10) + std::string(1023, 'x'));
  CHECK(peer.is_closed());
  receive<protocol::Force>(states);
}

}  // namespace acus::testing
