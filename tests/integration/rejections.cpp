// SPDX-License-Identifier: GPL-3.0-or-later
// Bad messages get their typed error and harm nothing.
#include <doctest/doctest.h>

#include <functional>
#include <limits>
#include <optional>
#include <zmq.hpp>

#include "tests/integration/server_process.h"

namespace acus::testing {
namespace {

// A client that sends bytes as they are.
class RawClient {
 public:
  RawClient(const ServerProcess& server, zmq::socket_type type) : socket_(context_, type) {
    socket_.set(zmq::sockopt::linger, 0);
    socket_.set(zmq::sockopt::rcvtimeo, static_cast<int>(kPatience.count()));
    socket_.connect(server.commands());
  }

  void send(const std::string& bytes, zmq::send_flags flags = zmq::send_flags::none) {
    socket_.send(zmq::buffer(bytes), flags);
  }

  protocol::Reply receive() {
    zmq::message_t message;
    REQUIRE(socket_.recv(message));
    return protocol::decode_reply(message.to_string_view());
  }

  std::string error_to(const std::string& bytes) {
    send(bytes);
    return name_of(std::get<protocol::Error>(receive()).code);
  }

  // Messages that arrive within the timeout after each other.
  // Until none has come for `quiet_ms`; a machine that is busy may take its time with the first.
  int count_messages(int quiet_ms) {
    socket_.set(zmq::sockopt::rcvtimeo, 30'000);
    int count = 0;
    for (zmq::message_t message; socket_.recv(message); ++count) socket_.set(zmq::sockopt::rcvtimeo, quiet_ms);
    return count;
  }

 private:
  zmq::context_t context_;
  zmq::socket_t socket_;
};

// The forces of a needle that moves up, as bytes, while another client does something now and then.
std::vector<std::string> forces_beside(const std::function<void(RawClient&)>& disturb) {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  RawClient other(server, zmq::socket_type::dealer);
  std::vector<std::string> forces;
  for (std::uint64_t i = 1; i <= 20; ++i) {
    CHECK(commands.send(pose_at(0.5 + 1e-4 * static_cast<double>(i), i)));
    commands.step(1, kPatience);
    forces.push_back(encode(receive<protocol::Force>(states)));
    if (i % 10 == 5) disturb(other);  // not at each: errors about streams are answered ten times a second
  }
  return forces;
}

std::string with_version(std::string bytes, char version) {
  bytes[bytes.find('v') + 1] = version;
  return bytes;
}

}  // namespace

TEST_CASE("each kind of bad message gets its own error, and the server goes on") {
  ServerProcess server;
  protocol::Pose not_finite = pose_at(std::numeric_limits<double>::quiet_NaN(), 1);
  protocol::Pose not_unit = pose_at(0.5, 1);
  not_unit.orientation.w = 2;
  protocol::Step no_ticks;
  no_ticks.ticks = 0;
  const std::string good = encode(pose_at(0.5, 1));
  const std::vector<std::pair<std::string, std::string>> cases{
      {good.substr(0, good.size() / 2), "truncated"},
      {good + "x", "trailing_bytes"},
      {encode(pose_at(0.5, 1, std::string(2 << 20, 'x'))), "oversized"},
      {std::string(1000, '\x91'), "too_complex"},
      {"\xc1", "invalid_msgpack"},
      {"\x01", "not_a_map"},
      {with_version(good, 1), "wrong_version"},
      {encode(protocol::Done{}), "unknown_type"},
      {"\x81\xa1v\x02", "missing_field"},
      {with_version(good, '\xc0'), "wrong_field_type"},
      {encode(not_finite), "not_finite"},
      {encode(not_unit), "not_unit_quaternion"},
      {encode(no_ticks), "bad_value"},
      {encode(pose_at(0.5, 1, "nobody")), "unknown_needle"},
      {good, "not_holder"}};
  for (const auto& [bytes, code] : cases) {
    CAPTURE(code);
    RawClient client(server, zmq::socket_type::dealer);
    CHECK(client.error_to(bytes) == code);
  }
  client::StateLink states = subscribe(server, {});
  CHECK(receive<protocol::Stats>(states).rejected == cases.size());
  client::CommandLink commands(server.commands());
  CHECK(commands.hello(kPatience).scene == "small");
}

TEST_CASE("positions and spins beyond all use are refused, and the needle goes on as if they had never come") {
  const auto pose = [](double x, std::optional<double> spin) {
    protocol::Pose message = pose_at(0.5, 99);
    message.position[0] = x;
    message.spin = spin;
    return encode(message);
  };
  protocol::Spin spin;
  spin.needle = "needle";
  spin.spin = -1e307;
  const std::vector<std::string> bad{pose(1e308, {}), pose(-1e308, 0.0), pose(0, 1e307), encode(spin)};
  const auto quiet = forces_beside([](RawClient&) {});
  const auto disturbed = forces_beside([&](RawClient& other) {
    for (const std::string& bytes : bad) CHECK(other.error_to(bytes) == "bad_value");
  });
  CHECK(quiet.size() == 20);
  CHECK(disturbed == quiet);  // decoded by the test's client, which takes no number that is not finite
}

TEST_CASE("a REQ client is served, also after its bad messages") {
  ServerProcess server;
  RawClient client(server, zmq::socket_type::req);
  CHECK(client.error_to("\xc1") == "invalid_msgpack");
  protocol::Hello hello;
  hello.seq = 5;
  client.send(encode(hello));
  CHECK(std::get<protocol::HelloReply>(client.receive()).seq == 5);
}

TEST_CASE("a client that also speaks later versions is answered in this one") {
  ServerProcess server;
  RawClient client(server, zmq::socket_type::dealer);
  protocol::Hello hello;
  hello.oldest_version = 2;
  client.send(with_version(encode(hello), 7));
  const auto reply = std::get<protocol::HelloReply>(client.receive());
  CHECK(reply.oldest_version == 2);
  CHECK(reply.newest_version == 2);
  hello.oldest_version = 3;
  CHECK(client.error_to(with_version(encode(hello), 7)) == "wrong_version");
}

TEST_CASE("a message of too many frames is rejected as a whole") {
  ServerProcess server;
  RawClient client(server, zmq::socket_type::dealer);
  const std::string hello = encode(protocol::Hello{});
  client.send(hello, zmq::send_flags::sndmore);
  client.send(hello, zmq::send_flags::sndmore);
  client.send(hello);
  CHECK(std::get<protocol::Error>(client.receive()).code == protocol::ErrorCode::invalid_msgpack);
  client.send(hello);
  CHECK(std::holds_alternative<protocol::HelloReply>(client.receive()));
}

TEST_CASE("a flood of bad streams is counted, but not answered one by one") {
  ServerProcess server;
  RawClient client(server, zmq::socket_type::dealer);
  for (int i = 0; i < 500; ++i) client.send(encode(pose_at(0.5, 1, "nobody")));
  const int errors = client.count_messages(2000);
  CHECK(errors >= 10);
  CHECK(errors < 400);
  client::StateLink states = subscribe(server, {});
  CHECK(receive<protocol::Stats>(states).rejected == 500);
}

}  // namespace acus::testing
