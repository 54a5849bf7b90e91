// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/endpoint.h"

#include <spdlog/fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <array>
#include <random>

#include "server/engine/state/snapshot.h"
#include "server/engine/state/state_bytes.h"
#include "server/runtime/convert.h"
#include "server/transport/readable_text.h"

namespace acus {
namespace {

using protocol::DecodeError;
using protocol::ErrorCode;
using std::chrono::milliseconds;

constexpr double kRequestsPerSecond = 20;          // of one client, of those that cost time
constexpr int kMessagesPerTurn = 16;               // received before states have their turn
constexpr std::size_t kBytesPerTurn = 1 << 20;     // likewise
constexpr std::size_t kMaxQuestionBytes = 200;     // of a message that is looked at before its turn
constexpr int kRecordsPerTurn = 1024;              // passed on before messages have theirs
constexpr int kAnswersLinger = 1000;               // ms to deliver the last answers
constexpr std::int64_t kMaxFrameBytes = 32 << 20;  // beyond it the client is disconnected
constexpr int kMaxAnswers = 100;                   // of one client that wait for it to read
constexpr int kMaxUnread = 16;                     // messages of one client that wait for this thread
// Of a client whose host is gone without a word, about 5 s: in ms, and in s and tries, one a second.
constexpr int kHeartbeat = 1000, kHeartbeatTimeout = 5000, kKeepaliveIdle = 2, kKeepaliveCount = 3;
constexpr auto kStatsPeriod = milliseconds(1000);
constexpr auto kFirstStatsPeriod = milliseconds(20);  // from when somebody listens to them
constexpr auto kEndingPoll = milliseconds(5);         // between two looks whether a recording's file is closed
constexpr auto kBlockedPoll = milliseconds(1);  // between two tries to send a state that is held back

// Whether it takes this thread, or the simulation's, more than some microseconds.
template <class Message>
constexpr bool kIsCostly =
    std::is_same_v<Message, protocol::Describe> || std::is_same_v<Message, protocol::Hash> ||
    std::is_same_v<Message, protocol::Snapshot> || std::is_same_v<Message, protocol::Restore> ||
    std::is_same_v<Message, protocol::Reset> || std::is_same_v<Message, protocol::Load> ||
    std::is_same_v<Message, protocol::Record> || std::is_same_v<Message, protocol::Pause> ||
    std::is_same_v<Message, protocol::Resume>;

// For the log; a step is too common.
bool changes_world(Request::Kind kind) {
  using enum Request::Kind;
  return kind != hash && kind != snapshot && kind != step;
}

std::uint64_t draw_instance() {
  std::random_device device;
  return (std::uint64_t{device()} << 32 | device()) | 1;  // not 0
}

bool is_shared(const LoadedScene& world) { return world.simulation.scene().clients.holding == Holding::any; }

std::string unknown(const std::string& name) {
  return "the scene has no needle or guide '" + name + "'; 'hello' lists them";
}

std::optional<ZapHandler> make_zap_handler(zmq::context_t& context, const Admission& admission) {
  if (!admission.curve) return std::nullopt;
  return std::optional<ZapHandler>(std::in_place, context, admission.curve->clients);
}

bool has_spin(const protocol::Pose& pose) { return pose.spin.has_value(); }
bool has_spin(const protocol::Spin&) { return true; }

}  // namespace

Endpoint::Endpoint(LoadedScene& world, const EndpointOptions& options, Link& link)
    : options_(options),
      link_(link),
      zap_(make_zap_handler(context_, options.admission)),
      commands_(context_, zmq::socket_type::router),
      inbox_(commands_),
      answers_(commands_),
      connections_(context_, commands_, "commands"),
      publisher_(context_, options.states, options.admission, options.lockstep),
      loader_(link.to_sockets, options.rate, SceneFolders(options.folders)),
      recordings_(options.recordings, ACUS_VERSION),
      snapshot_file_(options.snapshot),
      published_(&world),
      commanded_(&world),
      bodies_(static_cast<std::size_t>(world.body_count())),
      holders_(world.body_count(), is_shared(world)),
      instance_(draw_instance()),
      paused_(options.paused),
      request_limit_(kRequestsPerSecond),
      stats_begun_(Clock::now()),
      stats_period_(kStatsPeriod) {
  commands_.set(zmq::sockopt::linger, kAnswersLinger);
  commands_.set(zmq::sockopt::maxmsgsize, kMaxFrameBytes);
  commands_.set(zmq::sockopt::sndhwm, kMaxAnswers);
  commands_.set(zmq::sockopt::rcvhwm, kMaxUnread);
  commands_.set(zmq::sockopt::tcp_keepalive, 1);
  commands_.set(zmq::sockopt::tcp_keepalive_idle, kKeepaliveIdle);
  commands_.set(zmq::sockopt::tcp_keepalive_intvl, 1);
  commands_.set(zmq::sockopt::tcp_keepalive_cnt, kKeepaliveCount);
  if (!options.lockstep) {  // there a client's messages may wait for minutes, its answers among them
    commands_.set(zmq::sockopt::heartbeat_ivl, kHeartbeat);
    commands_.set(zmq::sockopt::heartbeat_timeout, kHeartbeatTimeout);
  }
  listen(commands_, "--commands", options.commands, options.admission);
  guard_.emplace(context_, publisher_.socket());
  if (!options.record.empty()) record_from_the_start();
}

// The simulation thread finds the request before its first tick.
void Endpoint::record_from_the_start() {
  recordings_.begin(options_.record);
  post(Request::Kind::record, [this](Request& request) { ask_to_record(request); });
}

std::string Endpoint::standing() const {
  return fmt::format("scene '{}', {} Hz{}{}", published_->hello.scene, published_->hello.rate,
                     options_.lockstep ? ", lockstep" : "", paused_ ? ", paused" : "");
}

void Endpoint::run(int signals, milliseconds longest_turn, const std::function<void()>& each_turn) {
  bool finished = false;
  while (!finished || !all_sent_) {
    if (wait_for_work(signals, longest_turn)) return;
    link_.to_sockets.clear();
    if (zap_) zap_->answer();
    finished = link_.finished.load(std::memory_order_acquire);
    update_wanted();
    link_.wanted.store(wanted_, std::memory_order_relaxed);
    receive_messages();
    finish_loading();
    finish_recording();
    all_sent_ = pass_on_records();
    ask_for_due_snapshot();
    publish_stats();
    each_turn();
  }
}

// The first to listen to stats gets them soon: they are how a client sees that its subscriptions have arrived, and how
// long ticks take, so there have to be some.
void Endpoint::update_wanted() {
  const bool had_listener = wanted_ & bit(Topic::stats);
  wanted_ = publisher_.update_subscriptions();
  if (had_listener || !(wanted_ & bit(Topic::stats))) return;
  stats_period_ = std::chrono::ceil<milliseconds>(Clock::now() - stats_begun_) + kFirstStatsPeriod;
}

// In lockstep a message is not dealt with before the request ahead of it.
bool Endpoint::listening() const { return !options_.lockstep || (waiting_.empty() && !loader_.busy()); }

// Sleeps until something happens or stats are due; true if it is a signal to end.
bool Endpoint::wait_for_work(int signals, milliseconds longest_turn) {
  const auto until_stats = std::chrono::ceil<milliseconds>(stats_begun_ + stats_period_ - Clock::now());
  const bool at_work = !all_sent_ || (listening() && inbox_.has_waiting());
  const auto unless_ending = std::min(until_stats, longest_turn);
  const auto longest = recordings_.is_ending() ? std::min(kEndingPoll, unless_ending) : unless_ending;
  const auto idle = at_work ? milliseconds(0) : std::max(milliseconds(0), longest);
  void* zap = zap_ ? zap_->socket().handle() : nullptr;  // without it the item is a file of number -1, which never is
  std::array<zmq::pollitem_t, 6> items{{{nullptr, signals, ZMQ_POLLIN, 0},
                                        {nullptr, link_.to_sockets.file(), ZMQ_POLLIN, 0},
                                        {publisher_.socket().handle(), 0, ZMQ_POLLIN, 0},
                                        {connections_.socket().handle(), 0, ZMQ_POLLIN, 0},
                                        {zap, -1, ZMQ_POLLIN, 0},
                                        {commands_.handle(), 0, ZMQ_POLLIN, 0}}};
  const bool room = listening() || !inbox_.full();
  zmq::poll(items.data(), room ? items.size() : items.size() - 1, blocked_ ? kBlockedPoll : idle);
  return (items[0].revents & ZMQ_POLLIN) != 0;
}

// ---- Messages ----

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
  const auto asked = [&](const auto& request) { return request.second.identity == client; };
  if (!message.framed || message.payload.size() > kMaxQuestionBytes) return false;
  if (inbox_.has_waiting_of(client) || std::ranges::any_of(waiting_, asked)) return false;
  if (loader_.busy() && loading_for_.identity == client) return false;
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
    if (!change->begun) forget_connection(change->connection);
  }
}

void Endpoint::forget_connection(int connection) {
  for (const auto& [id, sender] : waiting_)
    if (sender.connection == connection) link_.abandoned.store(id, std::memory_order_relaxed);
  inbox_.forget_connection(connection);
  forget_client(connection);
}

void Endpoint::forget_client(int connection) {
  const auto client = clients_.extract(connection);
  if (client.empty()) return;
  holders_.release_all(client.mapped());
  answers_.log({.identity = client.mapped()}, "is gone and holds nothing any more");
}

// Descriptors are used again, and a message may be read after its connection has ended: another client that speaks
// through a connection says that the one before is gone.
void Endpoint::keep_one_client(const Sender& sender) {
  const auto known = clients_.find(sender.connection);
  if (known != clients_.end() && known->second != sender.identity) forget_client(sender.connection);
}

void Endpoint::handle(const Arrived& message) {
  const Sender& sender = message.sender;
  keep_one_client(sender);
  try {
    if (!message.framed) {
      throw DecodeError(ErrorCode::invalid_msgpack, "a message must be one frame, or an empty frame and one more");
    }
    std::visit([&](const auto& command) { handle_if_affordable(sender, command); },
               protocol::decode_command(message.bytes()));
  } catch (const DecodeError& error) {
    answers_.reject(sender, error);
  }
}

// In real time what one client asks for takes time from all others; in lockstep they wait for each other anyway.
template <class Message>
void Endpoint::handle_if_affordable(const Sender& sender, const Message& message) {
  if (kIsCostly<Message> && !options_.lockstep && !request_limit_.allow(sender.identity, Clock::now())) {
    const std::string sentence =
        fmt::format("one client may ask for '{}' and the like {} times a second; try again later", Message::kType,
                    kRequestsPerSecond);
    return answers_.reject(sender, message, ErrorCode::busy, sentence);
  }
  handle(sender, message);
}

// ---- Requests ----

void Endpoint::handle(const Sender& sender, const protocol::Hello& request) {
  protocol::HelloReply reply = published_->hello;
  reply.seq = request.seq;
  reply.instance = instance_;
  reply.requests = request_types();
  reply.epoch = published_epoch_;
  for (int body = 0; published_ == commanded_ && body < commanded_->body_count(); ++body)
    if (holders_.held(body)) reply.held.push_back(commanded_->body_name(body));
  if (recordings_.state() == protocol::RecordingState::on) reply.recording = recordings_.name();
  reply.lockstep = options_.lockstep;
  reply.paused = paused_;
  answers_.send(sender, reply);
}

void Endpoint::handle(const Sender& sender, const protocol::Describe& request) {
  protocol::DescribeReply reply = published_->describe;
  reply.seq = request.seq;
  reply.epoch = published_epoch_;
  answers_.send(sender, reply);
}

template <class Message>
std::optional<std::vector<int>> Endpoint::find_bodies(const Sender& sender, const Message& message) {
  if (message.needles.size() > static_cast<std::size_t>(commanded_->body_count())) {
    answers_.reject(sender, message, ErrorCode::bad_value,
                    "field 'needles' must have at most as many names as the scene has needles and guides, " +
                        std::to_string(commanded_->body_count()) + ", found " + std::to_string(message.needles.size()));
    return std::nullopt;
  }
  std::vector<int> bodies;
  for (const std::string& name : message.needles) {
    bodies.push_back(commanded_->find_body(name));
    if (bodies.back() >= 0) continue;
    answers_.reject(sender, message, ErrorCode::unknown_needle, unknown(name));
    return std::nullopt;
  }
  return bodies;
}

void Endpoint::answer_holding(const Sender& sender, std::uint64_t seq) {
  protocol::Holding holding{seq, commanded_epoch_, {}};
  for (const int body : holders_.held_by(sender.identity)) holding.needles.push_back(commanded_->body_name(body));
  answers_.log(sender,
               holding.needles.empty() ? "holds nothing" : fmt::format("holds {}", fmt::join(holding.needles, ", ")));
  answers_.send(sender, holding);
}

void Endpoint::handle(const Sender& sender, const protocol::Acquire& request) {
  const auto bodies = find_bodies(sender, request);
  if (!bodies) return;
  notice_connections();
  if (!connections_.is_open(sender.connection)) return;  // its last words; nobody would ever release what it holds
  for (const int body : *bodies) {
    if (holders_.free_for(sender.identity, body)) continue;
    return answers_.reject(sender, request, ErrorCode::held,
                           "another client holds '" + commanded_->body_name(body) +
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

void Endpoint::handle(const Sender& sender, const protocol::Release& request) {
  const auto bodies = find_bodies(sender, request);
  if (!bodies) return;
  for (const int body : *bodies) holders_.release(sender.identity, body);
  answer_holding(sender, request.seq);
}

template <class Message>
bool Endpoint::may_change_world(const Sender& sender, const Message& message) {
  if (holders_.may_change_world(sender.identity)) return true;
  answers_.reject(
      sender, message, ErrorCode::not_holder,
      std::string("other clients hold needles of this scene and this one does not: '") + Message::kType +
          "' would change the world for them; 'acquire' a needle that is free, or wait until they release theirs");
  return false;
}

void Endpoint::handle(const Sender& sender, const protocol::Hash& request) {
  ask_for_state(sender, request, Request::Kind::hash);
}

void Endpoint::handle(const Sender& sender, const protocol::Snapshot& request) {
  ask_for_state(sender, request, Request::Kind::snapshot);
}

void Endpoint::handle(const Sender& sender, const protocol::Pause& request) {
  ask_in_real_time(sender, request, Request::Kind::pause);
}

void Endpoint::handle(const Sender& sender, const protocol::Resume& request) {
  ask_in_real_time(sender, request, Request::Kind::resume);
}

void Endpoint::handle(const Sender& sender, const protocol::Reset& request) {
  if (!may_change_world(sender, request)) return;
  ask(sender, request, Request::Kind::reset, [this](Request& reset) { begin_epoch(reset); });
}

void Endpoint::handle(const Sender& sender, const protocol::Load& request) {
  if (!may_change_world(sender, request)) return;
  if (loader_.busy())
    return answers_.reject(sender, request, ErrorCode::busy, "another scene is being loaded; try again later");
  if (request.scene.has_value() == request.text.has_value())
    return answers_.reject(sender, request, ErrorCode::bad_value,
                           "'load' needs either 'scene', a path, or 'text', a scene");
  if (request.text && request.text->empty())
    return answers_.reject(sender, request, ErrorCode::bad_value, "field 'text' must be a scene, found nothing");
  loading_ = request;
  loading_for_ = sender;
  loader_.start({request.scene.value_or(""), request.text.value_or("")});
}

void Endpoint::handle(const Sender& sender, const protocol::Restore& request) {
  if (!may_change_world(sender, request)) return;
  std::unique_ptr<State> state;
  try {
    const std::span<const std::uint8_t> bytes(request.snapshot);
    state = std::make_unique<State>(read_snapshot(commanded_->simulation.model(), std::as_bytes(bytes)));
  } catch (const SnapshotError& error) {
    return answers_.reject(sender, request, ErrorCode::snapshot_error, error.what());
  }
  ask(sender, request, Request::Kind::restore, [&](Request& restore) {
    begin_epoch(restore);
    restore.state = std::move(state);
  });
}

void Endpoint::handle(const Sender& sender, const protocol::Record& request) {
  if (!may_change_world(sender, request)) return;
  if (!link_.requests.writable()) return reject_for_want_of_room(sender, request);  // before there is a file
  try {
    if (request.file) {
      recordings_.begin_for_client(*request.file);
    } else {
      recordings_.ask_to_end();
    }
  } catch (const std::exception& error) {  // RecordingError, or no memory, no thread
    return answers_.reject(sender, request, ErrorCode::record_error, error.what());
  }
  ask(sender, request, Request::Kind::record, [this, &request](Request& record) {
    if (request.file) ask_to_record(record);
  });
}

void Endpoint::handle(const Sender& sender, const protocol::Step& request) {
  if (!options_.lockstep) {
    return answers_.reject(sender, request, ErrorCode::wrong_mode,
                           "'step' needs a server that was started with --lockstep");
  }
  notice_connections();
  if (!connections_.is_open(sender.connection)) return;  // its client is gone, and with it whoever wanted the ticks
  if (!may_change_world(sender, request)) return;
  ask(sender, request, Request::Kind::step, [&](Request& step) { step.ticks = request.ticks; });
}

void Endpoint::handle(const Sender& sender, const protocol::Shutdown& request) {
  if (!may_change_world(sender, request)) return;
  ask(sender, request, Request::Kind::shutdown, [](Request&) {});
}

// The simulation thread copies its state, this one makes of it what the client wants.
template <class Message>
void Endpoint::ask_for_state(const Sender& sender, const Message& message, Request::Kind kind) {
  if (copying_)
    return answers_.reject(sender, message, ErrorCode::busy, "another state is being copied; try again later");
  copying_ = ask(sender, message, kind, [this](Request& request) { request.state = room_for_state(); });
}

// For a scene that wants one every so many seconds. After a reset, or another scene, they count anew.
void Endpoint::ask_for_due_snapshot() {
  const Scene& scene = published_->simulation.scene();
  if (!scene.publish.snapshot_every || !snapshot_file_.ready() || due_snapshot_ || published_ != commanded_)
    return;
  const double now = static_cast<double>(link_.tick.load(std::memory_order_relaxed)) / scene.rate;
  if (now < last_snapshot_) last_snapshot_ = 0;
  if (now - last_snapshot_ < *scene.publish.snapshot_every) return;
  due_snapshot_ = post(Request::Kind::snapshot, [this](Request& request) { request.state = room_for_state(); });
  if (due_snapshot_) last_snapshot_ = now;
}

std::unique_ptr<State> Endpoint::room_for_state() const {
  return std::make_unique<State>(make_state(commanded_->simulation.model()));
}

template <class Message>
void Endpoint::ask_in_real_time(const Sender& sender, const Message& message, Request::Kind kind) {
  if (options_.lockstep) {
    const std::string sentence = std::string("in lockstep the world stands still anyway, '") + Message::kType +
                                 "' needs a server that was started without --lockstep";
    return answers_.reject(sender, message, ErrorCode::wrong_mode, sentence);
  }
  if (!may_change_world(sender, message)) return;
  ask(sender, message, kind, [](Request&) {});
}

template <class Message>
void Endpoint::reject_for_want_of_room(const Sender& sender, const Message& message) {
  answers_.reject(sender, message, ErrorCode::busy, "too many requests wait to be carried out; try again later");
}

template <class Message, class Prepare>
bool Endpoint::ask(const Sender& sender, const Message& message, Request::Kind kind, Prepare&& prepare) {
  const std::optional<std::uint64_t> id = post(kind, prepare);
  if (!id) {
    reject_for_want_of_room(sender, message);
    return false;
  }
  if (changes_world(kind)) answers_.log(sender, fmt::format("asks for '{}'", Message::kType));
  waiting_[*id] = {sender.identity, sender.delimited, message.seq, sender.connection};
  return true;
}

// Slots are used again: what the request before left in one is cleared.
template <class Prepare>
std::optional<std::uint64_t> Endpoint::post(Request::Kind kind, Prepare&& prepare) {
  Request* request = link_.requests.writable();
  if (!request) return std::nullopt;
  request->kind = kind;
  request->id = ++last_request_;
  request->recorder = nullptr;
  request->box.reset();
  prepare(*request);
  link_.requests.commit();
  link_.to_simulation.signal();
  return last_request_;
}

// What was commanded before ends with its epoch.
void Endpoint::begin_epoch(Request& request) {
  request.epoch = ++commanded_epoch_;
  bodies_.assign(static_cast<std::size_t>(commanded_->body_count()), {});
  if (recordings_.recorder()) request.box = make_box();
}

void Endpoint::ask_to_record(Request& request) {
  request.recorder = recordings_.recorder();
  request.box = make_box();
}

std::unique_ptr<StateBox> Endpoint::make_box() const {
  auto box = std::make_unique<StateBox>();
  box->state = make_state(commanded_->simulation.model());
  return box;
}

void Endpoint::finish_loading() {
  std::optional<LoadResult> result = loader_.take();
  if (!result) return;
  if (!result->world) return answers_.reject(loading_for_, loading_, ErrorCode::scene_error, result->error);
  // Others may have come meanwhile.
  if (!may_change_world(loading_for_, loading_)) return loader_.destroy(std::move(result->world));
  const bool asked = ask(loading_for_, loading_, Request::Kind::replace_world, [&](Request& request) {
    commanded_ = result->world.get();
    holders_ = Holders(commanded_->body_count(), is_shared(*commanded_));
    begin_epoch(request);
    request.world = std::move(result->world);
  });
  if (!asked) loader_.destroy(std::move(result->world));
}

protocol::Standing Endpoint::standing_of(const Sender& sender, const Acknowledgement& acknowledgement) {
  return {sender.seq, acknowledgement.epoch, acknowledgement.tick, acknowledgement.time};
}

void Endpoint::finish_request(Acknowledgement& acknowledgement) {
  published_epoch_ = acknowledgement.epoch;
  if (due_snapshot_ == acknowledgement.id) {
    due_snapshot_.reset();
    return snapshot_file_.write(acknowledgement.world->simulation.model().fingerprint,
                                std::move(acknowledgement.state));
  }
  switch (acknowledgement.kind) {
    case Request::Kind::pause:
      paused_ = true;
      break;
    case Request::Kind::resume:
      paused_ = false;
      break;
    case Request::Kind::replace_world:
      published_ = acknowledgement.world;
      spdlog::info("scene '{}' loaded", published_->hello.scene);
      loader_.destroy(std::move(acknowledgement.retired));
      break;
    case Request::Kind::hash:
    case Request::Kind::snapshot:
      copying_ = false;
      break;
    case Request::Kind::record:
      return finish_recording_request(acknowledgement);
    case Request::Kind::reset:
    case Request::Kind::restore:
    case Request::Kind::step:
    case Request::Kind::shutdown:
      break;
  }
  const auto sender = waiting_.extract(acknowledgement.id);
  const std::unique_ptr<State> state = std::move(acknowledgement.state);  // freed here, not in a tick
  const protocol::Standing standing = standing_of(sender.mapped(), acknowledgement);
  if (acknowledgement.kind == Request::Kind::hash) {
    answers_.send(sender.mapped(), protocol::HashReply{standing, comparable_hash(*state)});
  } else if (acknowledgement.kind == Request::Kind::snapshot) {
    send_snapshot(sender.mapped(), standing, acknowledgement.world->simulation.model(), *state);
  } else {
    answers_.send(sender.mapped(), protocol::Done{standing});
  }
}

// Nobody waits for an answer to what the command line asked for.
void Endpoint::finish_recording_request(const Acknowledgement& acknowledgement) {
  const auto sender = waiting_.extract(acknowledgement.id);
  if (!acknowledgement.recording && recordings_.recorder()) {
    recordings_.end();
    if (!sender.empty()) recording_ends_for_.emplace(sender.mapped(), standing_of(sender.mapped(), acknowledgement));
  } else if (!sender.empty()) {
    answers_.send(sender.mapped(), protocol::Done{standing_of(sender.mapped(), acknowledgement)});
  }
}

// Who ended it may use the file as soon as that is answered.
void Endpoint::finish_recording() {
  const auto ended = recordings_.take_ended();
  if (!ended || !recording_ends_for_) return;
  const auto [sender, standing] = *std::exchange(recording_ends_for_, std::nullopt);
  if (ended->whole) return answers_.send(sender, protocol::Done{standing});
  answers_.reject(
      sender, protocol::Record{.seq = standing.seq, .file = {}}, ErrorCode::record_error,
      "'" + ended->name + "' ended by itself, as the server's log says; what it holds up to there can be used");
}

void Endpoint::send_snapshot(const Sender& sender, const protocol::Standing& standing, const Model& model, State& state) {
  protocol::SnapshotReply reply{standing, comparable_hash(state), {}};
  const std::vector<std::byte> snapshot = make_snapshot(model.fingerprint, state);
  const auto* first = reinterpret_cast<const std::uint8_t*>(snapshot.data());
  reply.snapshot.assign(first, first + snapshot.size());
  answers_.send(sender, reply);
}

// ---- Streams ----

void Endpoint::handle(const Sender& sender, const protocol::Pose& pose) {
  update_command(sender, pose, [&](Command& command) {
    command.pose = Pose{from_wire(pose.position), from_wire(pose.orientation)};
    if (pose.spin) command.spin = pose.spin;
  });
}

void Endpoint::handle(const Sender& sender, const protocol::Spin& spin) {
  update_command(sender, spin, [&](Command& command) { command.spin = spin.spin; });
}

template <class Stream, class Change>
void Endpoint::update_command(const Sender& sender, const Stream& stream, Change&& change) {
  const int body = commanded_->find_body(stream.needle);
  if (body < 0) {
    return answers_.reject(sender, stream, ErrorCode::unknown_needle, unknown(stream.needle));
  }
  if (commanded_->is_guide(body) && has_spin(stream)) {
    return answers_.reject(
        sender, stream, ErrorCode::bad_value,
        "field 'spin' must not be given for '" + stream.needle + "', which is a guide and does not spin");
  }
  if (!holders_.holds(sender.identity, body)) {
    return answers_.reject(
        sender, stream, ErrorCode::not_holder,
        "this client does not hold '" + stream.needle + "' and cannot command it; 'acquire' it first");
  }
  const auto i = static_cast<std::size_t>(body);
  auto& [newest, origin, at, by] = bodies_[i];
  by = sender;
  count_command(origin, holders_.newest_seq(sender.identity, body), stream.seq, stream.time);
  const auto now = Clock::now();
  const std::chrono::duration<double> silence = now - std::exchange(at, now);
  // What was commanded before a silence ended with it.
  if (!options_.lockstep && silence.count() > commanded_->simulation.scene().clients.stale_after) newest = {};
  newest.seq = stream.seq;
  change(newest);
  link_.commands[i].put({commanded_epoch_, newest, origin});
}

// To whoever sent the body its newest command, as long as the epoch is the command's.
void Endpoint::tell_limit(const LimitRecord& beyond) {
  if (beyond.epoch != commanded_epoch_) return;
  const Commanded& commanded = bodies_[static_cast<std::size_t>(beyond.body)];
  const Clients& clients = commanded_->simulation.scene().clients;
  const std::string sentence = fmt::format(
      "'{}' may be told to go {} m and to turn {} rad at most from where it is (the scene's clients.max_step and "
      "max_turn); this pose is further away and was {}",
      commanded_->body_name(beyond.body), clients.max_step.value_or(kInfinity), clients.max_turn.value_or(kInfinity),
      beyond.acceptance == Acceptance::clamped ? "clamped" : "ignored");
  protocol::Pose pose;
  pose.seq = beyond.seq;
  answers_.reject(commanded.by, pose, ErrorCode::beyond_limit, sentence);
}

// ---- States ----

// True if nothing is left that the simulation thread said; bounded, so that messages have their turn.
bool Endpoint::pass_on_records() {
  for (int i = 0; i < kRecordsPerTurn; ++i) {
    blocked_ = !publisher_.flush();
    if (blocked_) return false;
    Record* record = link_.records.readable();
    if (!record) return pass_on_frames();
    if (auto* acknowledgement = std::get_if<Acknowledgement>(record)) {
      if (!pass_on_frames()) return false;  // an answer comes after all states before it
      finish_request(*acknowledgement);
    } else if (const auto* force = std::get_if<ForceRecord>(record)) {
      publisher_.publish(*force, *published_);
    } else if (const auto* event = std::get_if<EventRecord>(record)) {
      publisher_.publish(*event, *published_);
    } else if (const auto* haptics = std::get_if<HapticRecord>(record)) {
      publisher_.publish(*haptics, *published_);
    } else if (const auto* beyond = std::get_if<LimitRecord>(record)) {
      tell_limit(*beyond);
    } else {
      statistics_.add(std::get<TickRecord>(*record));
    }
    link_.records.release();
  }
  return false;
}

bool Endpoint::pass_on_frames() {
  while (!(blocked_ = !publisher_.flush())) {
    if (NeedleFrame* needle = published_->needle_frames.readable()) {
      publisher_.publish(*needle, *published_);
      published_->needle_frames.release();
    } else if (protocol::TissueShape* tissue = published_->tissue_frames.readable()) {
      publisher_.publish(*tissue);
      published_->tissue_frames.release();
    } else {
      return true;
    }
  }
  return false;
}

void Endpoint::publish_stats() {
  const Clock::time_point now = Clock::now();
  const std::chrono::duration<double> period = now - stats_begun_;
  if (period < stats_period_ || blocked_) return;
  const bool running = !paused_ && !options_.lockstep;
  if (running && statistics_.ticks() == 0 && period < kStatsPeriod) {  // the loop is about to begin
    stats_period_ += kFirstStatsPeriod;
    return;
  }
  stats_begun_ = now;
  stats_period_ = kStatsPeriod;
  protocol::Stats stats = statistics_.take();
  if (!(wanted_ & bit(Topic::stats))) return;
  stats.epoch = link_.epoch.load(std::memory_order_relaxed);
  stats.tick = link_.tick.load(std::memory_order_relaxed);
  stats.time = static_cast<double>(stats.tick) * published_->hello.time_step;
  stats.period = period.count();
  stats.paused = paused_;
  stats.overruns = link_.overruns.load(std::memory_order_relaxed);
  stats.rejected = answers_.rejected();
  stats.dropped = dropped();
  stats.recording = recordings_.state();
  if (StateBox& second = published_->second; second.full.load(std::memory_order_acquire)) {
    if (second.epoch == stats.epoch) stats.hash_tick = second.state.tick, stats.hash = comparable_hash(second.state);
    second.full.store(false, std::memory_order_release);
  }
  for (int i = 0; i < kTopicCount; ++i) {
    if (wanted_ & bit(static_cast<Topic>(i))) stats.subscribed.push_back(kTopicNames[i]);
  }
  publisher_.publish(stats);
}

}  // namespace acus
