// SPDX-License-Identifier: GPL-3.0-or-later
// Requests without a process: clients are messages, the simulation thread is the test, and time is what the test says.
#include "server/transport/requests.h"

#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace acus {
namespace {

using protocol::ErrorCode;

template <class... Messages>
bool all_have_a_rule(const std::variant<Messages...>*) {
  return sizeof...(Messages) == kRequestRules.size() && (... && (rule_of<Messages>().type == Messages::kType));
}

std::unique_ptr<LoadedScene> small_world(const char* name = "small") {
  Scene scene;
  scene.name = name;
  scene.tissue.rung = TissueRung::none;
  scene.needle_contact.enabled = false;  // one reaches into the other
  scene.needles.resize(2);
  scene.needles[0].name = "left";
  scene.needles[1].name = "right";
  scene.needles[1].base.position.x() = 0.1;
  return std::make_unique<LoadedScene>(scene);
}

// A server without threads: a client "a" and a client "b" on connections 1 and 2, both through one DEALER.
class Desk {
 public:
  explicit Desk(bool lockstep = false, bool paused = false)
      : world_(small_world()),
        router_(context_, zmq::socket_type::router),
        client_(context_, zmq::socket_type::dealer),
        answers_(router_, peers_),
        requests_(*world_, options(lockstep, paused), link_, answers_,
                  [this](int connection) { return connection != gone; }) {
    router_.set(zmq::sockopt::linger, 0);
    client_.set(zmq::sockopt::linger, 0);
    client_.set(zmq::sockopt::routing_id, "ab");
    router_.bind("inproc://desk");
    client_.connect("inproc://desk");
    client_.send(zmq::str_buffer("here"), zmq::send_flags::none);
    zmq::message_t message;
    while (!router_.recv(message, zmq::recv_flags::none) || message.to_string_view() != "here") {
    }
  }

  // Every client's answers go to the one socket there is.
  template <class Message>
  void say(const std::string& client, const Message& message) {
    requests_.handle({client == "a" ? "ab" : client, false, message.seq, client == "a" ? 1 : 2}, message, now);
  }

  // The newest answer to "a"; those before are forgotten.
  std::optional<protocol::Reply> answer() {
    std::optional<protocol::Reply> newest;
    zmq::message_t message;
    while (client_.recv(message, zmq::recv_flags::dontwait)) newest = protocol::decode_reply(message.to_string_view());
    return newest;
  }
  ErrorCode error() {
    const auto reply = answer();
    REQUIRE(reply);
    const auto* error = std::get_if<protocol::Error>(&*reply);
    REQUIRE(error);
    return error->code;
  }

  // What the simulation thread finds first, which must be a What.
  template <class What>
  const What& asked() {
    const Request* request = link_.requests.readable();
    REQUIRE(request);
    REQUIRE(std::holds_alternative<What>(request->what));
    return std::get<What>(request->what);
  }
  // Its part of it.
  template <class What>
  void carry_out() {
    asked<What>();
    Request* request = link_.requests.readable();
    Acknowledgement done{std::move(*request), requests_.world().commanded_epoch(), 7, 0.007, world_.get()};
    link_.requests.release();
    requests_.finish(done);
  }
  bool nothing_asked() { return link_.requests.readable() == nullptr; }

  std::optional<EpochCommand> command(int body) {
    const EpochCommand* fresh = link_.commands[static_cast<std::size_t>(body)].take();
    return fresh ? std::optional(*fresh) : std::nullopt;
  }

  Link& link() { return link_; }
  Requests& requests() { return requests_; }

  CommandStreams::Clock::time_point now{std::chrono::seconds(100)};
  int gone = -1;

 private:
  static RequestOptions options(bool lockstep, bool paused) {
    RequestOptions options;
    options.lockstep = lockstep;
    options.paused = paused;
    options.folders = {"/nowhere"};
    return options;
  }

  std::unique_ptr<LoadedScene> world_;
  zmq::context_t context_;
  zmq::socket_t router_, client_;
  Link link_;
  Peers peers_{{}};
  Answers answers_;
  Requests requests_;
};

protocol::Pose pose_of(const std::string& needle, std::uint64_t seq, double z) {
  protocol::Pose pose;
  pose.needle = needle;
  pose.seq = seq;
  pose.position = {0, 0, z};
  return pose;
}

}  // namespace

TEST_CASE("every type of message has a rule") {
  CHECK(all_have_a_rule(static_cast<const protocol::Command*>(nullptr)));
}

TEST_CASE("only who holds a needle commands it; pose and spin are one command") {
  Desk desk;
  desk.say("a", pose_of("left", 1, 0.1));
  CHECK(desk.error() == ErrorCode::not_holder);
  CHECK_FALSE(desk.command(0));
  desk.say("a", protocol::Acquire{{1, {"left"}}});
  CHECK(std::get<protocol::Holding>(*desk.answer()).needles == std::vector<std::string>{"left"});
  desk.say("a", pose_of("left", 1, 0.1));
  desk.say("a", protocol::Spin{"left", 2, 0, 3.0});
  const auto told = desk.command(0);
  REQUIRE(told);
  CHECK(told->command.seq == 2);
  CHECK(told->command.pose->position.z() == 0.1);
  CHECK(told->command.spin == 3.0);
  desk.say("a", pose_of("middle", 1, 0.1));
  CHECK(desk.error() == ErrorCode::unknown_needle);
}

TEST_CASE("what was commanded before a silence, a reset, or another holder is forgotten") {
  Desk desk;
  desk.say("a", protocol::Acquire{{1, {"left"}}});
  desk.say("a", pose_of("left", 1, 0.1));
  bool poses_stay = false;
  SUBCASE("a short silence is none") { desk.now += std::chrono::milliseconds(10), poses_stay = true; }
  SUBCASE("silence") { desk.now += std::chrono::seconds(10); }
  SUBCASE("reset") { desk.say("a", protocol::Reset{2}); }
  SUBCASE("another holder") {
    desk.say("a", protocol::Release{{2, {"left"}}});
    desk.say("b", protocol::Acquire{{1, {"left"}}});
    desk.say("b", protocol::Release{{2, {"left"}}});
    desk.say("a", protocol::Acquire{{3, {"left"}}});
  }
  desk.say("a", protocol::Spin{"left", 2, 0, 3.0});
  const auto told = desk.command(0);
  REQUIRE(told);
  CHECK(told->command.pose.has_value() == poses_stay);
  CHECK(told->command.spin == 3.0);
}

TEST_CASE("a client that holds nothing leaves the world alone while others hold something") {
  Desk desk;
  desk.say("b", protocol::Acquire{{1, {"right"}}});
  desk.say("a", protocol::Acquire{{2, {"right"}}});
  CHECK(desk.error() == ErrorCode::held);
  for (const protocol::Command& command :
       {protocol::Command(protocol::Pause{1}), protocol::Command(protocol::Resume{1}),
        protocol::Command(protocol::Reset{1}), protocol::Command(protocol::Shutdown{1}),
        protocol::Command(protocol::Restore{1, {1}}), protocol::Command(protocol::Record{1, "name"})}) {
    std::visit([&](const auto& message) { desk.say("a", message); }, command);
    CHECK(desk.error() == ErrorCode::not_holder);
  }
  CHECK(desk.nothing_asked());
  desk.requests().forget_connection(2);  // of b
  CHECK(desk.command(1)->abandoned);
  CHECK_FALSE(desk.command(0));
  desk.say("a", protocol::Reset{3});
  desk.carry_out<request::Reset>();
  CHECK(std::get<protocol::Done>(*desk.answer()).epoch == 1);
}

TEST_CASE("requests of the other mode are refused") {
  Desk real_time, lockstep(true);
  real_time.say("a", protocol::Step{1, 1});
  CHECK(real_time.error() == ErrorCode::wrong_mode);
  lockstep.say("a", protocol::Pause{1});
  CHECK(lockstep.error() == ErrorCode::wrong_mode);
  lockstep.say("a", protocol::Step{2, 5});
  CHECK(lockstep.asked<request::Step>().ticks == 5);
  lockstep.carry_out<request::Step>();
  CHECK(std::get<protocol::Done>(*lockstep.answer()).tick == 7);
}

TEST_CASE("a client that is gone acquires nothing, and nobody steps for it; a step under way goes no further") {
  Desk desk(true);
  desk.say("a", protocol::Step{1, 5});
  CHECK(desk.link().abandoned == kNoRequest);
  desk.requests().forget_connection(1);
  CHECK(desk.link().abandoned == 1);
  desk.carry_out<request::Step>();
  desk.gone = 1;
  desk.say("a", protocol::Acquire{{2, {"left"}}});
  desk.say("a", protocol::Step{3, 5});
  CHECK(desk.nothing_asked());
  CHECK(desk.requests().streams().held().empty());
}

TEST_CASE("in real time a client may ask for what costs time 20 times a second") {
  Desk desk;
  for (std::uint64_t i = 1; i <= 20; ++i) desk.say("a", protocol::Describe{i});
  CHECK(std::holds_alternative<protocol::DescribeReply>(*desk.answer()));
  desk.say("a", protocol::Describe{21});
  CHECK(desk.error() == ErrorCode::busy);
  desk.say("a", protocol::Hello{22});
  CHECK(std::holds_alternative<protocol::HelloReply>(*desk.answer()));
  desk.now += std::chrono::milliseconds(60);
  desk.say("a", protocol::Describe{23});
  CHECK(std::holds_alternative<protocol::DescribeReply>(*desk.answer()));
}

TEST_CASE("all clients together may ask 60 times a second, however often one of them connects anew") {
  Desk desk;
  for (int i = 0; i < 60; ++i) desk.say("client " + std::to_string(i), protocol::Describe{1});
  desk.say("a", protocol::Describe{1});
  CHECK(desk.error() == ErrorCode::busy);
  desk.now += std::chrono::milliseconds(20);
  desk.say("a", protocol::Describe{2});
  CHECK(std::holds_alternative<protocol::DescribeReply>(*desk.answer()));
}

TEST_CASE("one state is copied at a time, and its hash or snapshot is the answer") {
  Desk desk;
  desk.say("a", protocol::Hash{1});
  desk.say("a", protocol::Snapshot{2});
  CHECK(desk.error() == ErrorCode::busy);
  desk.carry_out<request::Hash>();
  CHECK(std::get<protocol::HashReply>(*desk.answer()).seq == 1);
  desk.say("a", protocol::Snapshot{3});
  desk.carry_out<request::Snapshot>();
  const auto reply = std::get<protocol::SnapshotReply>(*desk.answer());
  CHECK(reply.seq == 3);
  desk.say("a", protocol::Restore{4, reply.snapshot});
  desk.carry_out<request::Restore>();
  CHECK(std::get<protocol::Done>(*desk.answer()).epoch == 1);
  desk.say("a", protocol::Restore{5, {1, 2, 3}});
  CHECK(desk.error() == ErrorCode::snapshot_error);
}

TEST_CASE("more requests than the simulation thread has places for are refused, and change nothing") {
  Desk desk(true);
  for (std::uint64_t i = 1; i <= kMaxRequests; ++i) desk.say("a", protocol::Step{i, 1});
  CHECK_FALSE(desk.answer());
  desk.say("a", protocol::Reset{65});
  CHECK(desk.error() == ErrorCode::busy);
  CHECK(desk.requests().world().commanded_epoch() == 0);
  desk.say("a", protocol::Hash{66});
  CHECK(desk.error() == ErrorCode::busy);
  desk.carry_out<request::Step>();
  desk.say("a", protocol::Hash{67});  // the one before is not on its way
  CHECK_FALSE(std::holds_alternative<protocol::Error>(*desk.answer()));
}

TEST_CASE("pauses are known, also from the start, and to who asks") {
  Desk desk(false, true);
  CHECK(desk.requests().paused());
  desk.say("a", protocol::Resume{1});
  CHECK(desk.requests().paused());  // not before it has happened
  desk.carry_out<request::Resume>();
  CHECK_FALSE(desk.requests().paused());
  desk.say("a", protocol::Hello{2});
  CHECK_FALSE(std::get<protocol::HelloReply>(*desk.answer()).paused);
}

}  // namespace acus
