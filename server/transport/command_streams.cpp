// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/command_streams.h"

#include <spdlog/fmt/ranges.h>

#include <utility>

#include "server/runtime/convert.h"

namespace acus {
namespace {

using protocol::ErrorCode;

bool is_shared(const LoadedScene& world) { return world.simulation.scene().clients.holding == Holding::any; }

std::string unknown(const std::string& name) {
  return "the scene has no needle or guide '" + name + "'; 'hello' lists them";
}

bool has_spin(const protocol::Pose& pose) { return pose.spin.has_value(); }
bool has_spin(const protocol::Spin&) { return true; }

}  // namespace

CommandStreams::CommandStreams(const ServedWorld& world, bool lockstep, Link& link, Answers& answers)
    : world_(world), lockstep_(lockstep), link_(link), answers_(answers), holders_(0, false) {
  begin_world();
}

void CommandStreams::begin_world() {
  holders_ = Holders(world_.commanded().body_count(), is_shared(world_.commanded()));
  begin_epoch();
}

void CommandStreams::begin_epoch() { bodies_.assign(static_cast<std::size_t>(world_.commanded().body_count()), {}); }

std::vector<std::string> CommandStreams::held() const {
  std::vector<std::string> names;
  for (int body = 0; body < world_.commanded().body_count(); ++body)
    if (holders_.held(body)) names.push_back(world_.commanded().body_name(body));
  return names;
}

// The bodies of these names; nothing, and an error to the client, if one is unknown.
template <class Message>
std::optional<std::vector<int>> CommandStreams::find_bodies(const Sender& sender, const Message& message) {
  const LoadedScene& world = world_.commanded();
  if (message.needles.size() > static_cast<std::size_t>(world.body_count())) {
    answers_.reject(sender, message, ErrorCode::bad_value,
                    "field 'needles' must have at most as many names as the scene has needles and guides, " +
                        std::to_string(world.body_count()) + ", found " + std::to_string(message.needles.size()));
    return std::nullopt;
  }
  std::vector<int> bodies;
  for (const std::string& name : message.needles) {
    bodies.push_back(world.find_body(name));
    if (bodies.back() >= 0) continue;
    answers_.reject(sender, message, ErrorCode::unknown_needle, unknown(name));
    return std::nullopt;
  }
  return bodies;
}

void CommandStreams::answer_holding(const Sender& sender, std::uint64_t seq) {
  protocol::Holding holding{seq, world_.commanded_epoch(), {}};
  for (const int body : holders_.held_by(sender.identity))
    holding.needles.push_back(world_.commanded().body_name(body));
  answers_.log(sender,
               holding.needles.empty() ? "holds nothing" : fmt::format("holds {}", fmt::join(holding.needles, ", ")));
  answers_.send(sender, holding);
}

void CommandStreams::acquire(const Sender& sender, const protocol::Acquire& request) {
  const auto bodies = find_bodies(sender, request);
  if (!bodies) return;
  for (const int body : *bodies) {
    if (holders_.free_for(sender.identity, body)) continue;
    return answers_.reject(sender, request, ErrorCode::held,
                           "another client holds '" + world_.commanded().body_name(body) +
                               "', until it releases it or disconnects; a scene with clients.holding: any is shared");
  }
  for (const int body : *bodies) {
    if (holders_.holds(sender.identity, body)) continue;
    if (!holders_.held(body)) bodies_[static_cast<std::size_t>(body)].newest = {};  // what others wanted ends with them
    holders_.acquire(sender.identity, body);
  }
  clients_[sender.connection] = sender.identity;
  answer_holding(sender, request.seq);
}

void CommandStreams::release(const Sender& sender, const protocol::Release& request) {
  const auto bodies = find_bodies(sender, request);
  if (!bodies) return;
  for (const int body : *bodies) holders_.release(sender.identity, body);
  answer_holding(sender, request.seq);
}

void CommandStreams::forget_connection(int connection) {
  const auto client = clients_.extract(connection);
  if (client.empty()) return;
  const std::vector<int> held = holders_.held_by(client.mapped());
  holders_.release_all(client.mapped());
  for (const int body : held)
    if (!lockstep_ && !holders_.held(body))
      link_.commands[static_cast<std::size_t>(body)].put({world_.commanded_epoch(), {}, {}, true});
  if (!held.empty())
    answers_.log({.identity = client.mapped(), .connection = connection}, "is gone and holds nothing any more");
}

void CommandStreams::keep_one_client(const Sender& sender) {
  const auto known = clients_.find(sender.connection);
  if (known != clients_.end() && known->second != sender.identity) forget_connection(sender.connection);
}

void CommandStreams::take(const Sender& sender, const protocol::Pose& pose, Clock::time_point now) {
  update(sender, pose, now, [&](Command& command) {
    command.pose = Pose{from_wire(pose.position), from_wire(pose.orientation)};
    if (pose.spin) command.spin = pose.spin;
  });
}

void CommandStreams::take(const Sender& sender, const protocol::Spin& spin, Clock::time_point now) {
  update(sender, spin, now, [&](Command& command) { command.spin = spin.spin; });
}

template <class Stream, class Change>
void CommandStreams::update(const Sender& sender, const Stream& stream, Clock::time_point now, Change&& change) {
  const LoadedScene& world = world_.commanded();
  const int body = world.find_body(stream.needle);
  if (body < 0) return answers_.reject(sender, stream, ErrorCode::unknown_needle, unknown(stream.needle));
  if (world.is_guide(body) && has_spin(stream))
    return answers_.reject(
        sender, stream, ErrorCode::bad_value,
        "field 'spin' must not be given for '" + stream.needle + "', which is a guide and does not spin");
  if (!holders_.holds(sender.identity, body))
    return answers_.reject(
        sender, stream, ErrorCode::not_holder,
        "this client does not hold '" + stream.needle + "' and cannot command it; 'acquire' it first");
  const auto i = static_cast<std::size_t>(body);
  auto& [newest, origin, at, by] = bodies_[i];
  by = sender;
  count_command(origin, holders_.newest_seq(sender.identity, body), stream.seq, stream.time);
  const std::chrono::duration<double> silence = now - std::exchange(at, now);
  // What was commanded before a silence ended with it.
  if (!lockstep_ && silence.count() > world.simulation.scene().clients.stale_after) newest = {};
  newest.seq = stream.seq;
  change(newest);
  link_.commands[i].put({world_.commanded_epoch(), newest, origin});
}

void CommandStreams::tell_limit(const LimitRecord& beyond) {
  if (beyond.epoch != world_.commanded_epoch()) return;
  const Commanded& commanded = bodies_[static_cast<std::size_t>(beyond.body)];
  const Clients& clients = world_.commanded().simulation.scene().clients;
  const std::string sentence = fmt::format(
      "'{}' may be told to go {} m and to turn {} rad at most from where it is (the scene's clients.max_step and "
      "max_turn); this pose is further away and was {}",
      world_.commanded().body_name(beyond.body), clients.max_step.value_or(kInfinity),
      clients.max_turn.value_or(kInfinity), beyond.acceptance == Acceptance::clamped ? "clamped" : "ignored");
  protocol::Pose pose;
  pose.seq = beyond.seq;
  answers_.reject(commanded.by, pose, ErrorCode::beyond_limit, sentence);
}

}  // namespace acus
