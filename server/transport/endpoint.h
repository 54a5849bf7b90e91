// SPDX-License-Identifier: GPL-3.0-or-later
// The socket thread: serves the commands socket (ROUTER), feeds the publisher, and answers requests once the simulation
// thread has carried them out. protocol/README.md is what clients may rely on.
//
// In lockstep one request is dealt with after the other, and commands between two of them in the order in which they
// came, so that the same messages give the same run.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>
#include <zmq.hpp>

#include "protocol/codec.h"
#include "server/runtime/link.h"
#include "server/runtime/scene_loader.h"
#include "server/transport/answers.h"
#include "server/transport/connection_guard.h"
#include "server/transport/connection_monitor.h"
#include "server/transport/holders.h"
#include "server/transport/inbox.h"
#include "server/transport/listening.h"
#include "server/transport/publisher.h"
#include "server/transport/rate_limiter.h"
#include "server/transport/recordings.h"
#include "server/transport/snapshot_file.h"
#include "server/transport/tick_statistics.h"
#include "server/transport/zap_handler.h"

namespace acus {

struct EndpointOptions {
  std::string commands = protocol::kDefaultCommandsEndpoint;
  std::string states = protocol::kDefaultStatesEndpoint;
  bool lockstep = false;
  bool paused = false;               // as the simulation thread begins
  std::optional<double> rate;        // Hz, instead of that of every scene
  std::vector<std::string> folders;  // that clients may load scenes and meshes from; at least one
  std::string record;                // file to record into from the first tick on; empty: none
  std::string snapshot;              // file that the scene's snapshots go to; empty: none
  std::string recordings;            // folder that clients may record into; empty: none
  Admission admission;
};

class Endpoint {
 public:
  // Binds both sockets; throws CannotListen, RecordingError. `world` is the one the simulation thread starts with.
  Endpoint(LoadedScene& world, const EndpointOptions& options, Link& link);

  std::string commands_endpoint() const { return commands_.get(zmq::sockopt::last_endpoint); }
  std::string states_endpoint() const { return publisher_.endpoint(); }

  // Serves until the simulation thread has finished and everything it said is sent, or until `signals` (a file
  // descriptor) becomes readable. Calls each_turn() after `longest_turn` or a second at the latest.
  void run(int signals, std::chrono::milliseconds longest_turn, const std::function<void()>& each_turn);

  // What is simulated and how, in a line for people.
  std::string standing() const;

  std::uint64_t rejected() const { return answers_.rejected(); }
  bool recording_failed() const { return recordings_.state() == protocol::RecordingState::failed; }
  std::uint64_t dropped() const { return link_.dropped.load(std::memory_order_relaxed) + publisher_.dropped(); }

 private:
  using Clock = std::chrono::steady_clock;

  // What a needle or guide was told.
  struct Commanded {
    Command newest;  // pose and spin together, whichever message they came in
    CommandOrigin origin;
    Clock::time_point at;
    Sender by;
  };

  bool wait_for_work(int signals, std::chrono::milliseconds longest_turn);
  bool listening() const;

  void receive_messages();
  std::optional<Arrived> next_message();
  bool may_overtake(const Arrived& message) const;
  void handle(const Arrived& message);
  template <class Message>
  void handle_if_affordable(const Sender& sender, const Message& message);

  void handle(const Sender& sender, const protocol::Hello& request);
  void handle(const Sender& sender, const protocol::Describe& request);
  void handle(const Sender& sender, const protocol::Acquire& request);
  void handle(const Sender& sender, const protocol::Release& request);
  void handle(const Sender& sender, const protocol::Hash& request);
  void handle(const Sender& sender, const protocol::Snapshot& request);
  void handle(const Sender& sender, const protocol::Pause& request);
  void handle(const Sender& sender, const protocol::Resume& request);
  void handle(const Sender& sender, const protocol::Reset& request);
  void handle(const Sender& sender, const protocol::Load& request);
  void handle(const Sender& sender, const protocol::Restore& request);
  void handle(const Sender& sender, const protocol::Record& request);
  void handle(const Sender& sender, const protocol::Step& request);
  void handle(const Sender& sender, const protocol::Shutdown& request);
  void handle(const Sender& sender, const protocol::Pose& pose);
  void handle(const Sender& sender, const protocol::Spin& spin);

  template <class Message>
  void reject_for_want_of_room(const Sender& sender, const Message& message);
  // Sends a request to the simulation thread and remembers whom to answer; prepare(request) fills in what the kind
  // needs. False, and an error to the client, if too many wait already.
  template <class Message, class Prepare>
  bool ask(const Sender& sender, const Message& message, Request::Kind kind, Prepare&& prepare);
  // The same without a client; its number, or nothing where too many wait.
  template <class Prepare>
  std::optional<std::uint64_t> post(Request::Kind kind, Prepare&& prepare);
  std::unique_ptr<State> room_for_state() const;
  template <class Message>
  void ask_for_state(const Sender& sender, const Message& message, Request::Kind kind);
  // False, and an error to the client, if it may not change the world, because others hold needles and it does not.
  template <class Message>
  bool may_change_world(const Sender& sender, const Message& message);
  // The bodies of these names; nothing, and an error to the client, if one is unknown.
  template <class Message>
  std::optional<std::vector<int>> find_bodies(const Sender& sender, const Message& message);
  void answer_holding(const Sender& sender, std::uint64_t seq);
  void notice_connections();
  void forget_connection(int connection);
  void forget_client(int connection);
  void keep_one_client(const Sender& sender);
  void ask_for_due_snapshot();
  template <class Message>
  void ask_in_real_time(const Sender& sender, const Message& message, Request::Kind kind);
  void begin_epoch(Request& request);
  void record_from_the_start();
  void ask_to_record(Request& request);
  std::unique_ptr<StateBox> make_box() const;

  // Calls change(command) on the body's newest command and passes it to the simulation thread.
  template <class Stream, class Change>
  void update_command(const Sender& sender, const Stream& stream, Change&& change);

  void tell_limit(const LimitRecord& beyond);

  void finish_loading();
  bool pass_on_records();
  bool pass_on_frames();
  static protocol::Standing standing_of(const Sender& sender, const Acknowledgement& acknowledgement);
  void finish_request(Acknowledgement& acknowledgement);
  void finish_recording_request(const Acknowledgement& acknowledgement);
  void finish_recording();
  void send_snapshot(const Sender& sender, const protocol::Standing& standing, const Model& model, State& state);
  void update_wanted();
  void publish_stats();

  const EndpointOptions options_;
  Link& link_;
  zmq::context_t context_;
  std::optional<ZapHandler> zap_;  // with keys
  zmq::socket_t commands_;
  Inbox inbox_;
  Answers answers_;
  ConnectionMonitor connections_;
  Publisher publisher_;
  std::optional<ConnectionGuard> guard_;
  SceneLoader loader_;
  Recordings recordings_;
  std::optional<std::pair<Sender, protocol::Standing>> recording_ends_for_;  // who waits for the file's end
  SnapshotFile snapshot_file_;

  LoadedScene* published_;        // the world whose states come out
  const LoadedScene* commanded_;  // the world that commands go to: the same, or one on its way to the simulation thread
  std::uint64_t published_epoch_ = 0;
  std::uint64_t commanded_epoch_ = 0;
  std::vector<Commanded> bodies_;  // of commanded_
  Holders holders_;                // likewise
  std::unordered_map<int, std::string> clients_;  // that hold something, by their connections
  const std::uint64_t instance_;                  // of this start of the server
  bool paused_;
  bool copying_ = false;  // a copy of the state is on its way
  std::optional<std::uint64_t> due_snapshot_;  // the request that it is for, where the scene asked
  double last_snapshot_ = 0;                   // s of simulation time

  std::uint64_t last_request_ = 0;
  std::unordered_map<std::uint64_t, Sender> waiting_;  // requests with the simulation thread
  protocol::Load loading_;                             // the request that the loader works on,
  Sender loading_for_;                                 // and whose it is

  RateLimiter request_limit_;
  TopicSet wanted_ = 0;
  TickStatistics statistics_;
  Clock::time_point stats_begun_;
  std::chrono::milliseconds stats_period_;
  bool blocked_ = false;   // the publisher holds a state back
  bool all_sent_ = false;  // nothing that the simulation thread said so far waits
};

}  // namespace acus
