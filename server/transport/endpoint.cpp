// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/endpoint.h"

#include <spdlog/fmt/fmt.h>

#include <array>
#include <new>

namespace acus {
namespace {

using protocol::DecodeError;
using std::chrono::milliseconds;

constexpr int kMessagesPerTurn = 16;               // received before states have their turn
constexpr std::size_t kBytesPerTurn = 1 << 20;     // likewise
constexpr std::size_t kMaxQuestionBytes = 200;     // of a message that is looked at before its turn
constexpr int kAnswersLinger = 1000;               // ms to deliver the last answers
constexpr std::int64_t kMaxFrameBytes = 32 << 20;  // beyond it the client is disconnected
constexpr int kMaxAnswers = 100;                   // of one client that wait for it to read
constexpr int kMaxUnread = 16;                     // messages of one client that wait for this thread
// Of a client whose host is gone without a word, about 5 s: in ms, and in s and tries, one a second.
constexpr int kHeartbeat = 1000, kHeartbeatTimeout = 5000, kKeepaliveIdle = 2, kKeepaliveCount = 3;
constexpr auto kEndingPoll = milliseconds(5);   // between two looks whether a recording's file is closed
constexpr auto kBlockedPoll = milliseconds(1);  // between two tries to send a state that is held back

std::optional<ZapHandler> make_zap_handler(zmq::context_t& context, const Admission& admission) {
  if (!admission.curve) return std::nullopt;
  return std::optional<ZapHandler>(std::in_place, context, admission.curve->clients);
}

void bound(zmq::socket_t& commands, bool lockstep) {
  commands.set(zmq::sockopt::linger, kAnswersLinger);
  commands.set(zmq::sockopt::maxmsgsize, kMaxFrameBytes);
  commands.set(zmq::sockopt::sndhwm, kMaxAnswers);
  commands.set(zmq::sockopt::rcvhwm, kMaxUnread);
  commands.set(zmq::sockopt::tcp_keepalive, 1);
  commands.set(zmq::sockopt::tcp_keepalive_idle, kKeepaliveIdle);
  commands.set(zmq::sockopt::tcp_keepalive_intvl, 1);
  commands.set(zmq::sockopt::tcp_keepalive_cnt, kKeepaliveCount);
  if (lockstep) return;  // there a client's messages may wait for minutes, its answers among them
  commands.set(zmq::sockopt::heartbeat_ivl, kHeartbeat);
  commands.set(zmq::sockopt::heartbeat_timeout, kHeartbeatTimeout);
}

}  // namespace

Endpoint::Endpoint(LoadedScene& world, const EndpointOptions& options, Link& link)
    : lockstep_(options.lockstep),
      link_(link),
      zap_(make_zap_handler(context_, options.admission)),
      commands_(context_, zmq::socket_type::router),
      inbox_(commands_),
      peers_(options.admission.curve ? options.admission.curve->clients : std::vector<protocol::PublicKey>{}),
      answers_(commands_, peers_),
      connections_(context_, commands_, "commands"),
      feed_(context_, options.states, options.admission, options.lockstep, link,
            {[this](Acknowledgement& acknowledgement) { requests_.finish(acknowledgement); },
             [this](const LimitRecord& beyond) { requests_.streams().tell_limit(beyond); }}),
      requests_(world, options, link, answers_, [this](int connection) {
        notice_connections();
        return connections_.is_open(connection);
      }) {
  bound(commands_, options.lockstep);
  listen(commands_, "--commands", options.commands, options.admission);
  guard_.emplace(context_, feed_.socket(), options.admission.curve.has_value());
  if (!options.record.empty()) requests_.record_from_the_start(options.record);
}

std::string Endpoint::standing() const {
  const protocol::HelloReply& hello = requests_.world().published().hello;
  return fmt::format("scene '{}', {} Hz{}{}", hello.scene, hello.rate, lockstep_ ? ", lockstep" : "",
                     requests_.paused() ? ", paused" : "");
}

void Endpoint::run(int signals, milliseconds longest_turn, const std::function<void()>& each_turn) {
  bool finished = false;
  while (!finished || !feed_.all_sent()) {
    if (wait_for_work(signals, longest_turn)) return;
    link_.to_sockets.clear();
    if (zap_) zap_->answer();
    finished = link_.finished.load(std::memory_order_acquire);
    feed_.update_wanted();
    receive_messages();
    feed_.pass_on(requests_.world());
    requests_.turn();
    feed_.publish_stats(requests_.world(), {requests_.paused(), answers_.rejected(), requests_.recordings().state()});
    each_turn();
  }
}

// In lockstep a message is not dealt with before the request ahead of it.
bool Endpoint::listening() const { return !lockstep_ || requests_.idle(); }

// Sleeps until something happens or stats are due; true if it is a signal to end.
bool Endpoint::wait_for_work(int signals, milliseconds longest_turn) {
  const bool at_work = !feed_.all_sent() || (listening() && inbox_.has_waiting());
  const auto unless_ending = std::min({feed_.until_stats(), longest_turn, requests_.until_snapshot()});
  const auto longest = requests_.recordings().is_ending() ? std::min(kEndingPoll, unless_ending) : unless_ending;
  const auto idle = at_work ? milliseconds(0) : std::max(milliseconds(0), longest);
  void* zap = zap_ ? zap_->socket().handle() : nullptr;  // without it the item is a file of number -1, which never is
  std::array<zmq::pollitem_t, 6> items{{{nullptr, signals, ZMQ_POLLIN, 0},
                                        {nullptr, link_.to_sockets.file(), ZMQ_POLLIN, 0},
                                        {feed_.socket().handle(), 0, ZMQ_POLLIN, 0},
                                        {connections_.socket().handle(), 0, ZMQ_POLLIN, 0},
                                        {zap, -1, ZMQ_POLLIN, 0},
                                        {commands_.handle(), 0, ZMQ_POLLIN, 0}}};
  const bool room = listening() || !inbox_.full();
  zmq::poll(items.data(), room ? items.size() : items.size() - 1, feed_.blocked() ? kBlockedPoll : idle);
  return (items[0].revents & ZMQ_POLLIN) != 0;
}

void Endpoint::receive_messages() {
  notice_connections();
  std::size_t bytes = 0;
  for (int i = 0; i < kMessagesPerTurn && bytes < kBytesPerTurn; ++i) {
    std::optional<Arrived> message = next_message();
    if (!message) return;
    bytes += message->payload.size();
    if (listening() || may_overtake(*message)) {
      handle(*message);
    } else {
      inbox_.put_aside(std::move(*message));
    }
  }
}

std::optional<Arrived> Endpoint::next_message() {
  if (listening() && inbox_.has_waiting()) return inbox_.take_waiting();
  if (!listening() && inbox_.full()) return std::nullopt;
  std::optional<Arrived> message = inbox_.receive();
  if (message) guard_->took(*message);
  return message;
}

// Whether it may be answered before its turn: a question that has the same answer anyway, of a client that nothing else
// of is ahead, so that it notices no other order than its own.
bool Endpoint::may_overtake(const Arrived& message) const {
  const std::string& client = message.sender.identity;
  if (!message.framed || message.payload.size() > kMaxQuestionBytes) return false;
  if (inbox_.has_waiting_of(client) || requests_.any_of(client)) return false;
  try {
    const protocol::Command command = protocol::decode_command(message.bytes());
    return std::holds_alternative<protocol::Hello>(command) || std::holds_alternative<protocol::Describe>(command);
  } catch (const DecodeError&) {
    return false;
  }
}

// Lost ones before the messages of those that came after them, which may have their connections' numbers.
void Endpoint::notice_connections() {
  while (const auto change = connections_.next_change()) {
    guard_->note(*change);
    if (change->begun) continue;
    inbox_.forget_connection(change->connection);
    requests_.forget_connection(change->connection);
    peers_.forget(change->connection);
  }
}

void Endpoint::handle(const Arrived& message) {
  const Sender& sender = message.sender;
  peers_.note(message);
  requests_.streams().keep_one_client(sender);
  try {
    if (!message.framed)
      throw DecodeError(protocol::ErrorCode::invalid_msgpack,
                        "a message must be one frame, or an empty frame and one more");
    requests_.handle(sender, protocol::decode_command(message.bytes()), std::chrono::steady_clock::now());
  } catch (const DecodeError& error) {
    answers_.reject(sender, error);
  } catch (const std::bad_alloc&) {
    answers_.reject(sender, DecodeError(protocol::ErrorCode::busy, "there is no memory to read it; try again later"));
  }
}

}  // namespace acus
