// SPDX-License-Identifier: MIT
#include "client/link/client.h"

#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "client/link/socket.h"

namespace acus::client {
namespace {

constexpr int kLingerMilliseconds = 100;    // that closing a link waits for commands to leave
constexpr int kReconnectMilliseconds = 50;  // between attempts to reach a server that is not there

std::unique_ptr<Socket> open_commands(const std::string& endpoint, const std::optional<CurveKeys>& keys) {
  return std::make_unique<Socket>(zmq::socket_type::dealer, endpoint, keys, [](zmq::socket_t& socket) {
    socket.set(zmq::sockopt::linger, kLingerMilliseconds);
    socket.set(zmq::sockopt::reconnect_ivl, kReconnectMilliseconds);
  });
}

std::unique_ptr<Socket> open_states(const std::string& endpoint, int capacity, const std::optional<CurveKeys>& keys) {
  return std::make_unique<Socket>(zmq::socket_type::sub, endpoint, keys, [capacity](zmq::socket_t& socket) {
    socket.set(zmq::sockopt::linger, 0);
    socket.set(zmq::sockopt::reconnect_ivl, kReconnectMilliseconds);
    socket.set(zmq::sockopt::rcvhwm, capacity);
  });
}

// Poses and spins are the only messages that have no answer of their own.
bool is_stream_rejection(const protocol::Error& error) {
  return error.rejected == protocol::Pose::kType || error.rejected == protocol::Spin::kType;
}

bool answers(const protocol::Error& error, std::uint64_t seq) {
  return !is_stream_rejection(error) && error.seq.value_or(seq) == seq;
}

template <class Decoded, class Decode>
Decoded decode_or_mismatch(Decode decode, std::string_view bytes, const std::string& endpoint) {
  try {
    return decode(bytes, protocol::kMaxStateBytes);
  } catch (const protocol::DecodeError& error) {
    throw ProtocolMismatch("endpoint '" + endpoint + "' does not speak version " + std::to_string(protocol::kVersion) +
                           " of the protocol: " + error.what());
  }
}

std::string shown(Timeout timeout) { return std::to_string(timeout.count()) + " ms"; }

}  // namespace

CommandLink::CommandLink(const std::string& endpoint, const std::optional<CurveKeys>& keys)
    : socket_(open_commands(endpoint, keys)) {}
CommandLink::~CommandLink() = default;
CommandLink::CommandLink(CommandLink&&) noexcept = default;
CommandLink& CommandLink::operator=(CommandLink&&) noexcept = default;

template <class Message>
bool CommandLink::send_now(const Message& message) {
  protocol::encode(message, buffer_);
  return socket_->send(buffer_);
}

template <class Answer, class Request>
Answer CommandLink::request(Request request, Timeout timeout) {
  const auto deadline = Socket::Clock::now() + timeout;
  request.seq = ++last_request_;
  const std::string vanished =
      "no answer to '" + std::string(Request::kType) + "' from '" + socket_->endpoint() + "' within " + shown(timeout);
  if (!socket_->wait_for_peer(deadline) || !send_now(request)) throw Vanished(vanished + ": " + socket_->why_no_peer());

  while (socket_->wait_for_message(deadline, /*while_connected=*/true)) {
    std::string_view bytes;
    if (!socket_->receive(bytes)) continue;
    auto reply = decode_or_mismatch<protocol::Reply>(protocol::decode_reply, bytes, socket_->endpoint());
    if (auto* answer = std::get_if<Answer>(&reply); answer && answer->seq == request.seq) return std::move(*answer);
    const auto* error = std::get_if<protocol::Error>(&reply);
    if (!error) continue;  // the late answer to an earlier request
    if (is_stream_rejection(*error)) keep_rejection(*error);
    if (!answers(*error, request.seq)) continue;
    if (error->code == protocol::ErrorCode::wrong_version) throw ProtocolMismatch(Refused(*error).what());
    throw Refused(*error);
  }
  throw Vanished(socket_->connected() ? vanished : vanished + ": the connection ended");
}

protocol::HelloReply CommandLink::hello(Timeout timeout) {
  return request<protocol::HelloReply>(protocol::Hello{}, timeout);
}
protocol::DescribeReply CommandLink::describe(Timeout timeout) {
  return request<protocol::DescribeReply>(protocol::Describe{}, timeout);
}
protocol::Holding CommandLink::acquire(const std::vector<std::string>& needles, Timeout timeout) {
  return request<protocol::Holding>(protocol::Acquire{{0, needles}}, timeout);
}
protocol::Holding CommandLink::release(const std::vector<std::string>& needles, Timeout timeout) {
  return request<protocol::Holding>(protocol::Release{{0, needles}}, timeout);
}
protocol::HashReply CommandLink::hash(Timeout timeout) {
  return request<protocol::HashReply>(protocol::Hash{}, timeout);
}
protocol::SnapshotReply CommandLink::snapshot(Timeout timeout) {
  return request<protocol::SnapshotReply>(protocol::Snapshot{}, timeout);
}
protocol::Done CommandLink::pause(Timeout timeout) { return request<protocol::Done>(protocol::Pause{}, timeout); }
protocol::Done CommandLink::resume(Timeout timeout) { return request<protocol::Done>(protocol::Resume{}, timeout); }
protocol::Done CommandLink::reset(Timeout timeout) { return request<protocol::Done>(protocol::Reset{}, timeout); }
protocol::Done CommandLink::load(const std::string& scene, Timeout timeout) {
  protocol::Load load;
  load.scene = scene;
  return request<protocol::Done>(load, timeout);
}
protocol::Done CommandLink::load_text(const std::string& scene, Timeout timeout) {
  protocol::Load load;
  load.text = scene;
  return request<protocol::Done>(load, timeout);
}
protocol::Done CommandLink::restore(const std::vector<std::uint8_t>& snapshot, Timeout timeout) {
  protocol::Restore restore;
  restore.snapshot = snapshot;
  return request<protocol::Done>(std::move(restore), timeout);
}

protocol::Done CommandLink::record(const std::string& file, Timeout timeout) {
  protocol::Record record;
  record.file = file;
  return request<protocol::Done>(std::move(record), timeout);
}

protocol::Done CommandLink::end_recording(Timeout timeout) {
  return request<protocol::Done>(protocol::Record(), timeout);
}
protocol::Done CommandLink::step(std::uint32_t ticks, Timeout timeout) {
  protocol::Step step;
  step.ticks = ticks;
  return request<protocol::Done>(step, timeout);
}
protocol::Done CommandLink::shutdown(Timeout timeout) { return request<protocol::Done>(protocol::Shutdown{}, timeout); }

bool CommandLink::connected() { return socket_->connected(); }

// Without a peer a command would wait in the queue and reach a later server out of date.
bool CommandLink::send(const protocol::Pose& pose) { return connected() && send_now(pose); }
bool CommandLink::send(const protocol::Spin& spin) { return connected() && send_now(spin); }

void CommandLink::keep_rejection(const protocol::Error& error) {
  if (rejections_.size() == kMaxRejections) rejections_.pop_front();
  rejections_.push_back(error);
}

std::optional<protocol::Error> CommandLink::next_rejection() {
  std::string_view bytes;
  while (rejections_.empty() && socket_->receive(bytes)) {
    const auto reply = decode_or_mismatch<protocol::Reply>(protocol::decode_reply, bytes, socket_->endpoint());
    if (const auto* error = std::get_if<protocol::Error>(&reply)) keep_rejection(*error);
  }
  if (rejections_.empty()) return std::nullopt;
  auto oldest = std::move(rejections_.front());
  rejections_.pop_front();
  return oldest;
}

StateLink::StateLink(const std::string& endpoint, int capacity, const std::optional<CurveKeys>& keys)
    : socket_(open_states(endpoint, capacity, keys)) {}
StateLink::~StateLink() = default;
StateLink::StateLink(StateLink&&) noexcept = default;
StateLink& StateLink::operator=(StateLink&&) noexcept = default;

void StateLink::subscribe(const std::string& topic) { socket_->raw().set(zmq::sockopt::subscribe, topic); }
void StateLink::unsubscribe(const std::string& topic) { socket_->raw().set(zmq::sockopt::unsubscribe, topic); }

std::optional<protocol::State> StateLink::receive(Timeout timeout) {
  std::string_view bytes;
  if (!socket_->receive(bytes)) {
    const auto deadline = Socket::Clock::now() + timeout;
    if (!socket_->wait_for_message(deadline, /*while_connected=*/false)) return std::nullopt;
    if (!socket_->receive(bytes)) return std::nullopt;
  }
  return decode_or_mismatch<protocol::State>(protocol::decode_state, bytes, socket_->endpoint());
}

}  // namespace acus::client
