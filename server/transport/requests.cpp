// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/requests.h"

#include <spdlog/spdlog.h>

#include <new>
#include <random>
#include <system_error>

#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"

namespace acus {
namespace {

using protocol::ErrorCode;

// Of those that cost time: of one client, and of all together, since a client that connects anew is another one.
constexpr const char* kNoMemory = "there is not enough memory for it beside the world that goes on; try again later";
constexpr std::chrono::milliseconds kSnapshotPoll(10);  // while one is due, and cannot be asked for
constexpr double kRequestsPerSecond = 20, kRequestsOfAll = 60;

std::uint64_t draw_instance() {
  std::random_device device;
  return (std::uint64_t{device()} << 32 | device()) | 1;  // not 0
}

}  // namespace

Requests::Requests(LoadedScene& world, const RequestOptions& options, Link& link, Answers& answers, IsOpen is_open)
    : options_(options),
      link_(link),
      answers_(answers),
      is_open_(std::move(is_open)),
      instance_(draw_instance()),
      world_(world),
      streams_(world_, options.lockstep, link, answers),
      pending_(link),
      limit_(kRequestsPerSecond),
      limit_of_all_(kRequestsOfAll),
      paused_(options.paused),
      loader_(link.to_sockets, options.rate, SceneFolders(options.folders), !options.lockstep),
      recordings_(options.recordings, ACUS_VERSION),
      snapshot_file_(options.snapshot) {}

void Requests::record_from_the_start(const std::string& file) {
  recordings_.begin(file);
  pending_.post(request::Record{recordings_.recorder(), world_.make_box()});
}

void Requests::handle(const Sender& sender, const protocol::Command& command, Clock::time_point now) {
  now_ = now;
  std::visit([&](const auto& message) { handle_by_rule(sender, message); }, command);
}

// ---- What all have in common ----

template <class Message>
void Requests::handle_by_rule(const Sender& sender, const Message& message) {
  try {
    if (may(sender, message)) handle(sender, message);
  } catch (const std::bad_alloc&) {
    answers_.reject(sender, message, ErrorCode::busy, kNoMemory);
  }
}

template <class Message>
bool Requests::may(const Sender& sender, const Message& message) {
  constexpr RequestRule kRule = rule_of<Message>();
  // In real time what one client asks for takes time from all others; in lockstep they wait for each other anyway.
  if (kRule.costly && !options_.lockstep) {
    const bool one = limit_.allow(sender.identity, now_);
    if (!one || !limit_of_all_.allow("", now_)) {
      answers_.reject(sender, message, ErrorCode::busy,
                      fmt::format("{} may ask for '{}' and the like {} times a second; try again later",
                                  one ? "all clients together" : "one client", Message::kType,
                                  one ? kRequestsOfAll : kRequestsPerSecond));
      return false;
    }
  }
  if (kRule.mode == RequestRule::Mode::real_time && options_.lockstep) {
    answers_.reject(sender, message, ErrorCode::wrong_mode,
                    fmt::format("in lockstep the world stands still anyway, '{}' needs a server that was started "
                                "without --lockstep",
                                Message::kType));
    return false;
  }
  if (kRule.mode == RequestRule::Mode::lockstep && !options_.lockstep) {
    answers_.reject(sender, message, ErrorCode::wrong_mode,
                    fmt::format("'{}' needs a server that was started with --lockstep", Message::kType));
    return false;
  }
  // Of a client that is gone nobody wants the ticks.
  if (kRule.mode == RequestRule::Mode::lockstep && !is_open_(sender.connection)) return false;
  return !kRule.changes_world || may_change_world(sender, message);
}

template <class Message>
bool Requests::may_change_world(const Sender& sender, const Message& message) {
  if (streams_.may_change_world(sender.identity)) return true;
  answers_.reject(
      sender, message, ErrorCode::not_holder,
      std::string("other clients hold needles of this scene and this one does not: '") + Message::kType +
          "' would change the world for them; 'acquire' a needle that is free, or wait until they release theirs");
  return false;
}

template <class Message>
bool Requests::has_room(const Sender& sender, const Message& message) {
  if (pending_.has_room()) return true;
  answers_.reject(sender, message, ErrorCode::busy, "too many requests wait to be carried out; try again later");
  return false;
}

template <class Message, class What>
void Requests::ask(const Sender& sender, const Message& message, What what) {
  if (!has_room(sender, message)) return;
  constexpr RequestRule kRule = rule_of<Message>();
  if (kRule.changes_world && kRule.mode != RequestRule::Mode::lockstep)  // a step is too common
    answers_.log(sender, fmt::format("asks for '{}'", Message::kType));
  pending_.ask(sender, message.seq, std::move(what));
}

// What was commanded before ends with its epoch.
NewEpoch Requests::begin_epoch() {
  NewEpoch epoch = world_.begin_epoch(recordings_.recorder() != nullptr);
  streams_.begin_epoch();
  return epoch;
}

void Requests::forget_connection(int connection) {
  pending_.abandon(connection);
  streams_.forget_connection(connection);
}

void Requests::turn() {
  finish_loading();
  finish_recording();
  ask_for_due_snapshot();
}

// ---- Each request ----

void Requests::handle(const Sender& sender, const protocol::Hello& request) {
  protocol::HelloReply reply = world_.published().hello;
  reply.seq = request.seq;
  reply.instance = instance_;
  reply.requests = request_types();
  reply.epoch = world_.published_epoch();
  if (world_.settled()) reply.held = streams_.held();
  if (recordings_.state() == protocol::RecordingState::on) reply.recording = recordings_.name();
  reply.lockstep = options_.lockstep;
  reply.paused = paused_;
  answers_.send(sender, reply);
}

void Requests::handle(const Sender& sender, const protocol::Describe& request) {
  protocol::DescribeReply reply = world_.published().describe;
  reply.seq = request.seq;
  reply.epoch = world_.published_epoch();
  answers_.send(sender, reply);
}

// Of a client that is gone: its last words; nobody would ever release what it holds.
void Requests::handle(const Sender& sender, const protocol::Acquire& request) {
  if (is_open_(sender.connection)) streams_.acquire(sender, request);
}

void Requests::handle(const Sender& sender, const protocol::Release& request) { streams_.release(sender, request); }

void Requests::handle(const Sender& sender, const protocol::Hash& request) {
  ask_for_state<request::Hash>(sender, request);
}

void Requests::handle(const Sender& sender, const protocol::Snapshot& request) {
  ask_for_state<request::Snapshot>(sender, request);
}

// The simulation thread copies its state, this one makes of it what the client wants.
template <class What, class Message>
void Requests::ask_for_state(const Sender& sender, const Message& message) {
  if (copying_)
    return answers_.reject(sender, message, ErrorCode::busy, "another state is being copied; try again later");
  if (!has_room(sender, message)) return;
  What what{world_.make_room()};
  copying_ = true;
  ask(sender, message, std::move(what));
}

void Requests::handle(const Sender& sender, const protocol::Pause& request) { ask(sender, request, request::Pause{}); }
void Requests::handle(const Sender& sender, const protocol::Resume& request) {
  ask(sender, request, request::Resume{});
}

void Requests::handle(const Sender& sender, const protocol::Reset& request) {
  if (has_room(sender, request)) ask(sender, request, request::Reset{begin_epoch()});
}

void Requests::handle(const Sender& sender, const protocol::Load& request) {
  if (loader_.busy())
    return answers_.reject(sender, request, ErrorCode::busy, "another scene is being loaded; try again later");
  if (request.scene.has_value() == request.text.has_value())
    return answers_.reject(sender, request, ErrorCode::bad_value,
                           "'load' needs either 'scene', a path, or 'text', a scene");
  if (request.text && request.text->empty())
    return answers_.reject(sender, request, ErrorCode::bad_value, "field 'text' must be a scene, found nothing");
  loading_ = request;
  loading_for_ = sender;
  try {
    loader_.start({request.scene.value_or(""), request.text.value_or("")});
  } catch (const std::system_error& error) {
    answers_.reject(sender, request, ErrorCode::busy,
                    fmt::format("the system gives no thread to load it with ({}); try again later, or let the server "
                                "have more threads (ulimit -u) or memory (ulimit -v)",
                                error.code().message()));
  }
}

void Requests::finish_loading() {
  std::optional<LoadResult> result = loader_.take();
  if (!result) return;
  if (!result->world) return answers_.reject(loading_for_, loading_, ErrorCode::scene_error, result->error);
  // Others may have come meanwhile.
  if (!may_change_world(loading_for_, loading_) || !has_room(loading_for_, loading_))
    return loader_.destroy(std::move(result->world));
  request::ReplaceWorld replacement;
  try {
    replacement.epoch = world_.begin_epoch(*result->world, recordings_.recorder() != nullptr);
  } catch (const std::bad_alloc&) {
    answers_.reject(loading_for_, loading_, ErrorCode::busy, kNoMemory);
    return loader_.destroy(std::move(result->world));
  }
  replacement.world = std::move(result->world);
  streams_.begin_world();
  ask(loading_for_, loading_, std::move(replacement));
}

void Requests::handle(const Sender& sender, const protocol::Restore& request) {
  std::unique_ptr<State> state;
  try {
    const std::span<const std::uint8_t> bytes(request.snapshot);
    state = std::make_unique<State>(read_snapshot(world_.commanded().simulation.model(), std::as_bytes(bytes)));
  } catch (const SnapshotError& error) {
    return answers_.reject(sender, request, ErrorCode::snapshot_error, error.what());
  }
  if (has_room(sender, request)) ask(sender, request, request::Restore{begin_epoch(), std::move(state)});
}

void Requests::handle(const Sender& sender, const protocol::Record& request) {
  if (!has_room(sender, request)) return;  // before there is a file
  request::Record recording{nullptr, request.file ? world_.make_box() : nullptr};
  try {
    if (request.file) {
      recordings_.begin_for_client(*request.file);
      recording.recorder = recordings_.recorder();
    } else {
      recordings_.ask_to_end();
    }
  } catch (const std::exception& error) {  // RecordingError, or no memory, no thread
    return answers_.reject(sender, request, ErrorCode::record_error, error.what());
  }
  ask(sender, request, std::move(recording));
}

void Requests::handle(const Sender& sender, const protocol::Step& request) {
  ask(sender, request, request::Step{request.ticks});
}

void Requests::handle(const Sender& sender, const protocol::Shutdown& request) {
  ask(sender, request, request::Shutdown{});
}

double Requests::simulation_time() const {
  return static_cast<double>(link_.tick.load(std::memory_order_relaxed)) / world_.published().simulation.scene().rate;
}

std::chrono::milliseconds Requests::until_snapshot() const {
  const std::optional<double>& every = world_.published().simulation.scene().publish.snapshot_every;
  if (!every || paused_ || !snapshot_file_.ready() || snapshot_due_) return std::chrono::days(1);
  const double left = last_snapshot_ + *every - simulation_time();  // s
  return std::max(kSnapshotPoll, std::chrono::milliseconds(std::llround(1e3 * std::min(left, 1e3))));
}

// For a scene that wants one every so many seconds. After a reset, or another scene, they count anew.
void Requests::ask_for_due_snapshot() {
  const Scene& scene = world_.published().simulation.scene();
  snapshot_file_.tell_if_slow(SnapshotFile::Clock::now());
  if (!scene.publish.snapshot_every || !snapshot_file_.ready() || snapshot_due_ || !world_.settled()) return;
  const double now = simulation_time();
  if (now < last_snapshot_) last_snapshot_ = 0;
  if (now - last_snapshot_ < *scene.publish.snapshot_every || !pending_.has_room()) return;
  last_snapshot_ = now;
  try {
    pending_.post(request::DueSnapshot{world_.make_room()});
    snapshot_due_ = true;
  } catch (const std::bad_alloc&) {
    spdlog::error("--snapshot: there is no memory for the one that is due; the next one is tried");
  }
}

// ---- What comes back ----

// With all that came back in it, which is freed here and not in a tick.
void Requests::finish(Acknowledgement& acknowledgement) {
  Request request = std::move(acknowledgement.request);
  world_.publish(*acknowledgement.world, acknowledgement.epoch);
  const std::optional<Sender> sender = pending_.finish(request.id);
  std::visit(
      [&](auto& what) {
        take_in(what, acknowledgement);
        if (!sender) return;
        const protocol::Standing standing{sender->seq, acknowledgement.epoch, acknowledgement.tick,
                                          acknowledgement.time};
        answer(*sender, what, standing, acknowledgement.world->simulation.model());
      },
      request.what);
}

void Requests::take_in(request::DueSnapshot& snapshot, const Acknowledgement& acknowledgement) {
  snapshot_due_ = false;
  snapshot_file_.write(acknowledgement.world->simulation.model().fingerprint, std::move(snapshot.state));
}

void Requests::take_in(request::ReplaceWorld& replacement, const Acknowledgement&) {
  spdlog::info("scene '{}' loaded", world_.published().hello.scene);
  loader_.destroy(std::move(replacement.world));
}

void Requests::take_in(request::Record& recording, const Acknowledgement&) {
  if (!recording.recorder && recordings_.recorder()) recordings_.end();
}

void Requests::answer(const Sender& sender, request::Hash& hash, const protocol::Standing& standing, const Model&) {
  answers_.send(sender, protocol::HashReply{standing, comparable_hash(*hash.state)});
}

void Requests::answer(const Sender& sender, request::Snapshot& snapshot, const protocol::Standing& standing,
                      const Model& model) {
  protocol::SnapshotReply reply{standing, comparable_hash(*snapshot.state), {}};
  snapshot.state->economizing = false;  // who continues from it has time
  try {
    const std::vector<std::byte> bytes = make_snapshot(model.fingerprint, *snapshot.state);
    const auto* first = reinterpret_cast<const std::uint8_t*>(bytes.data());
    reply.snapshot.assign(first, first + bytes.size());
    answers_.send(sender, reply);
  } catch (const std::bad_alloc&) {
    protocol::Snapshot request;
    request.seq = standing.seq;
    answers_.reject(sender, request, ErrorCode::busy, kNoMemory);
  }
}

// Who ended a recording may use the file as soon as that is answered.
void Requests::answer(const Sender& sender, request::Record& recording, const protocol::Standing& standing,
                      const Model&) {
  if (!recording.recorder && recordings_.is_ending()) {
    recording_ends_for_.emplace(sender, standing);
  } else {
    answers_.send(sender, protocol::Done{standing});
  }
}

void Requests::finish_recording() {
  const auto ended = recordings_.take_ended();
  if (!ended || !recording_ends_for_) return;
  const auto [sender, standing] = *std::exchange(recording_ends_for_, std::nullopt);
  if (ended->whole) return answers_.send(sender, protocol::Done{standing});
  answers_.reject(
      sender, protocol::Record{.seq = standing.seq, .file = {}}, ErrorCode::record_error,
      "'" + ended->name + "' ended by itself, as the server's log says; what it holds up to there can be used");
}

}  // namespace acus
