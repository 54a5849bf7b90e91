// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/client/mock_server.h"

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <map>
#include <string_view>
#include <utility>
#include <variant>
#include <zmq.hpp>

#include "protocol/codec.h"

namespace acus::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kStatsPeriod = 20ms;  // shorter than a real server's, to keep the tests short

struct NeedleState {
  std::uint64_t seq = 0;
  protocol::Vector3 position{};
};

// One session of the mock, with sockets that exist while it does.
class Session {
 public:
  Session(const MockScript& script, const std::string& commands, const std::string& states,
          std::atomic<std::uint64_t>& poses, std::atomic<std::uint64_t>& ticks)
      : script_(script), poses_(poses), ticks_(ticks) {
    commands_.set(zmq::sockopt::linger, 10'000);  // the answer to `shutdown` must leave, however busy the machine is
    states_.set(zmq::sockopt::linger, 0);
    commands_.bind(commands);
    states_.bind(states);
    for (const auto& needle : script.needles) needles_[needle].seq = script.first_seq;
  }

  bool ended() const { return shut_down_ || (script_.last_tick && ticks_ >= *script_.last_tick); }
  bool shut_down() const { return shut_down_; }

  void turn() {
    zmq::pollitem_t item{commands_.handle(), 0, ZMQ_POLLIN, 0};
    zmq_poll(&item, 1, 1);
    while (!ended() && answer_one()) {
    }
    take_subscriptions();
    if (!script_.lockstep && !script_.paused && Clock::now() >= next_tick_) tick();
    if (Clock::now() >= next_stats_) publish_stats();
  }

  void operator()(const protocol::Hello& hello) {
    protocol::HelloReply reply;
    reply.seq = hello.seq;
    reply.server = "mock";
    reply.scene = "mock scene";
    reply.rate = script_.rate;
    reply.time_step = 1 / script_.rate;
    reply.lockstep = script_.lockstep;
    reply.paused = script_.paused;
    for (const auto& name : script_.needles) reply.needles.emplace_back().name = name;
    for (const auto& name : script_.guides) reply.guides.emplace_back().name = name;
    const double shape_rate = script_.rate / static_cast<double>(script_.shape_ticks);
    reply.topics = {{"needle", shape_rate}, {"tissue", shape_rate}};
    send(reply);
  }
  void operator()(const protocol::Describe& describe) {
    protocol::DescribeReply reply;
    reply.seq = describe.seq;
    reply.regions = {"tissue"};
    send(reply);
  }
  void operator()(const protocol::Acquire& acquire) {
    protocol::Holding holding;
    holding.seq = acquire.seq;
    holding.needles = acquire.needles;
    send(holding);
  }
  void operator()(const protocol::Step& step) {
    for (std::uint32_t i = 0; i < step.ticks; ++i) tick();
    done(step.seq);
  }
  void operator()(const protocol::Resume& resume) {
    script_.paused = false;
    done(resume.seq);
  }
  void operator()(const protocol::Shutdown& shutdown) {
    done(shutdown.seq);
    shut_down_ = true;
  }
  void operator()(const protocol::Pose& pose) {
    ++poses_;
    if (script_.rejects_poses) return reject(pose.seq, protocol::Pose::kType, protocol::ErrorCode::bad_value);
    if (needles_.contains(pose.needle)) needles_[pose.needle] = {pose.seq, pose.position};
    if (poses_ == 1) publish_event();
  }
  template <class Other>
  void operator()(const Other& other) {
    reject(other.seq, Other::kType, protocol::ErrorCode::wrong_mode);
  }

 private:
  bool answer_one() {
    zmq::message_t identity;
    zmq::message_t payload;
    if (!commands_.recv(identity, zmq::recv_flags::dontwait)) return false;
    if (!commands_.recv(payload, zmq::recv_flags::dontwait)) return false;
    identity_ = identity.to_string();
    const auto command = protocol::decode_command(payload.to_string_view());
    const bool is_request = !std::holds_alternative<protocol::Pose>(command);
    if (is_request && script_.mute) return true;
    if (is_request && script_.rejects_requests) {
      std::visit([this](const auto& m) { reject(m.seq, m.kType, protocol::ErrorCode::busy); }, command);
      return true;
    }
    std::visit(*this, command);
    return true;
  }

  template <class Reply>
  void send(const Reply& reply) {
    std::string bytes = protocol::encode(reply);
    bytes[bytes.find('v') + 1] = static_cast<char>(script_.version);
    commands_.send(zmq::buffer(identity_), zmq::send_flags::sndmore);
    commands_.send(zmq::buffer(bytes));
  }

  void done(std::uint64_t seq) {
    protocol::Done done;
    done.seq = seq;
    done.epoch = 1;
    done.tick = tick_;
    send(done);
  }

  void reject(std::uint64_t seq, const char* type, protocol::ErrorCode code) {
    protocol::Error error;
    error.seq = seq;
    error.rejected = type;
    error.code = code;
    error.message = "as the script says";
    send(error);
  }

  void take_subscriptions() {
    zmq::message_t message;
    while (states_.recv(message, zmq::recv_flags::dontwait)) {
    }
  }

  template <class State>
  void publish(const State& state) {
    const std::string bytes = protocol::encode(state);
    states_.send(zmq::buffer(std::string_view(State::kType)), zmq::send_flags::sndmore);
    states_.send(zmq::buffer(bytes));
  }

  void tick() {
    next_tick_ +=
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / (script_.pace * script_.rate)));
    tick_ = script_.reset_tick && tick_ == *script_.reset_tick ? 1 : tick_ + 1;
    ++ticks_;
    if (script_.lossy_pose > 0 && poses_ >= script_.lossy_pose) {
      script_.lossy_pose = 0;
      return;
    }
    for (const auto& [name, needle] : needles_) publish(force_on(name, needle));
    const std::uint64_t interval = script_.shape_ticks * (script_.loses_shapes ? 2 : 1);
    if (tick_ % interval == 0) publish_shapes();
  }

  void publish_shapes() {
    protocol::TissueShape tissue;
    tissue.tick = tick_;
    tissue.positions = {0, 0, static_cast<float>(tick_)};
    tissue.path_points = {1, 2, 3};
    tissue.path_sizes = {1};
    publish(tissue);
    for (const auto& [name, state] : needles_) {
      protocol::NeedleShape needle;
      needle.tick = tick_;
      needle.needle = name;
      needle.positions.assign(state.position.begin(), state.position.end());
      needle.orientations = {1, 0, 0, 0};
      publish(needle);
    }
  }

  // Pushes back along -x of the base by the depth of the base below z = 0, in newtons.
  protocol::Force force_on(const std::string& name, const NeedleState& needle) const {
    protocol::Force force;
    force.epoch = 1;
    force.tick = tick_;
    force.time = static_cast<double>(tick_) / script_.rate;
    force.needle = name;
    force.seq = needle.seq;
    force.base_position = needle.position;
    force.depth = std::max(-needle.position[2], 0.0);
    force.base_force_in_base = {-force.depth, 0, 0};
    return force;
  }

  void publish_event() {
    protocol::Event event;
    event.epoch = 1;
    event.tick = tick_;
    event.needle = script_.needles.front();
    event.kind = protocol::EventKind::puncture;
    event.force = 1;
    publish(event);
  }

  void publish_stats() {
    next_stats_ = Clock::now() + kStatsPeriod;
    protocol::Stats stats;
    stats.tick = tick_;
    publish(stats);
  }

  MockScript script_;
  std::atomic<std::uint64_t>& poses_;
  std::atomic<std::uint64_t>& ticks_;
  zmq::context_t context_;
  zmq::socket_t commands_{context_, zmq::socket_type::router};
  zmq::socket_t states_{context_, zmq::socket_type::xpub};
  std::string identity_;  // of the client being answered
  std::map<std::string, NeedleState> needles_;
  std::uint64_t tick_ = 0;
  Clock::time_point next_tick_ = Clock::now();
  Clock::time_point next_stats_ = Clock::now();
  bool shut_down_ = false;
};

}  // namespace

ReservedPort::ReservedPort() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const int on = 1;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  REQUIRE(::setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on)) == 0);
  REQUIRE(::bind(socket_, generic, size) == 0);
  REQUIRE(::getsockname(socket_, generic, &size) == 0);
  endpoint_ = "tcp://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
}

ReservedPort::~ReservedPort() { ::close(socket_); }

MockServer::MockServer(const MockScript& script, int delay_ms)
    : script_(script), thread_([=, this] { serve(delay_ms); }) {}

MockServer::~MockServer() {
  stop_ = true;
  thread_.join();
}

void MockServer::serve(int delay_ms) {
  std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
  Session session(script_, commands(), states(), poses_, ticks_);
  while (!stop_ && !session.ended()) session.turn();
  was_shut_down_ = session.shut_down();
}

}  // namespace acus::test
