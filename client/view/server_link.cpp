// SPDX-License-Identifier: MIT
#include "client/view/server_link.h"

#include <chrono>
#include <variant>

#include "client/view/watched_socket.h"
#include "protocol/codec.h"

namespace acus::view {

namespace {

constexpr auto kHelloPeriod = std::chrono::milliseconds(500);  // between two `hello`
constexpr int kUnansweredHellos = 4;  // `hello` without an answer until the server counts as gone
constexpr int kWaiting = 20'000;      // states that may wait; viewers get the newest
constexpr int kCommandsWaiting = 8;   // for a server that takes none; further ones are dropped
constexpr const char* kTopics[] = {"force", "needle", "tissue", "event", "stats"};

}  // namespace

ServerLink::ServerLink(boost::asio::io_context& context, ServerAddress address, Listener listener)
    : context_(context), address_(std::move(address)), listener_(std::move(listener)), clock_(context) {
  const auto take_state = [this](std::string_view bytes) {
    if (watching_) listener_.state(frame_of(bytes));
  };
  states_ = std::make_unique<WatchedSocket>(context_, zmq::socket_type::sub, address_.states, address_.keys, take_state,
                                            [](zmq::socket_t& socket) { socket.set(zmq::sockopt::rcvhwm, kWaiting); });
  const auto take_answer = [this](std::string_view bytes) { this->take_answer(bytes); };
  questions_ = std::make_unique<WatchedSocket>(context_, zmq::socket_type::dealer, address_.commands, address_.keys,
                                               take_answer, [](zmq::socket_t& socket) {
                                                 socket.set(zmq::sockopt::linger, 0);
                                                 socket.set(zmq::sockopt::sndhwm, 2 * kUnansweredHellos);
                                               });
  ask_again();
}

ServerLink::~ServerLink() = default;

void ServerLink::ask_again() {
  questions_->send(protocol::encode(protocol::Hello{++seq_}));
  if (++unanswered_ > kUnansweredHellos) here_ = false;
  clock_.expires_after(kHelloPeriod);
  clock_.async_wait([this](const boost::system::error_code& error) {
    if (!error) ask_again();
  });
}

void ServerLink::take_answer(std::string_view bytes) {
  try {
    const protocol::Reply reply = protocol::decode_reply(bytes);
    if (const auto* hello = std::get_if<protocol::HelloReply>(&reply)) take_hello(*hello, bytes);
    if (std::holds_alternative<protocol::DescribeReply>(reply)) describe_ = std::make_shared<const std::string>(bytes);
  } catch (const protocol::DecodeError&) {  // no server of Acus, or of another version: it does not count as here
  }
}

void ServerLink::take_hello(const protocol::HelloReply& hello, std::string_view bytes) {
  unanswered_ = 0;
  const auto begun = std::pair(hello.instance, hello.epoch);
  if (described_ != begun) {
    described_ = begun;
    questions_->send(protocol::encode(protocol::Describe{++seq_}));
  }
  hello_ = std::make_shared<const std::string>(bytes);
  lockstep_ = hello.lockstep;
  if (!std::exchange(here_, true)) listener_.arrived();
}

void ServerLink::watch(bool wanted) {
  if (wanted == watching_) return;
  watching_ = wanted;
  for (const char* topic : kTopics) {
    if (wanted) {
      states_->raw().set(zmq::sockopt::subscribe, topic);
    } else {
      states_->raw().set(zmq::sockopt::unsubscribe, topic);
    }
  }
}

void ServerLink::begin_driving() {
  const auto take = [this](std::string_view bytes) {
    Frame frame;
    frame.bytes = std::make_shared<const std::string>(bytes);
    listener_.answer(frame);
  };
  driving_ = std::make_unique<WatchedSocket>(context_, zmq::socket_type::dealer, address_.commands, address_.keys, take,
                                             [](zmq::socket_t& socket) {
                                               socket.set(zmq::sockopt::linger, 0);
                                               socket.set(zmq::sockopt::sndhwm, kCommandsWaiting);
                                             });
}

void ServerLink::end_driving() { driving_.reset(); }

void ServerLink::drive(std::string_view message) {
  if (driving_ && here_) driving_->send(message);
}

}  // namespace acus::view
