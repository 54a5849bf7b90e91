// SPDX-License-Identifier: GPL-3.0-or-later
// What clients ask for: checked against request_rules.h, passed to the simulation thread or to the loader where it is
// theirs to do, and answered when it is done. On the socket thread.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/codec.h"
#include "server/runtime/link.h"
#include "server/runtime/scene_loader.h"
#include "server/transport/answers.h"
#include "server/transport/command_streams.h"
#include "server/transport/pending_requests.h"
#include "server/transport/rate_limiter.h"
#include "server/transport/recordings.h"
#include "server/transport/request_rules.h"
#include "server/transport/served_world.h"
#include "server/transport/snapshot_file.h"

namespace acus {

struct RequestOptions {
  bool lockstep = false;
  bool paused = false;               // as the simulation thread begins
  std::optional<double> rate;        // Hz, instead of that of every scene
  std::vector<std::string> folders;  // that clients may load scenes and meshes from; at least one
  std::string snapshot;              // file that the scene's snapshots go to; empty: none
  std::string recordings;            // folder that clients may record into; empty: none
};

class Requests {
 public:
  using Clock = CommandStreams::Clock;
  // Whether a connection is open, as of now.
  using IsOpen = std::function<bool(int connection)>;

  // `world` is the one that the simulation thread starts with.
  Requests(LoadedScene& world, const RequestOptions& options, Link& link, Answers& answers, IsOpen is_open);

  // Before the simulation thread's first tick. Throws RecordingError.
  void record_from_the_start(const std::string& file);

  void handle(const Sender& sender, const protocol::Command& command, Clock::time_point now);
  // The simulation thread has carried one out.
  void finish(Acknowledgement& acknowledgement);
  // What other threads have done, and what the scene wants.
  void turn();

  // Whether a thread is at work that outlives this: it loads a scene, or writes a snapshot.
  bool leaves_thread() const { return loader_.busy() || snapshot_file_.writing(); }
  // Nothing is under way, of anybody or of a client.
  bool idle() const { return pending_.none() && !loader_.busy(); }
  bool any_of(const std::string& client) const {
    return pending_.any_of(client) || (loader_.busy() && loading_for_.identity == client);
  }

  const ServedWorld& world() const { return world_; }
  CommandStreams& streams() { return streams_; }
  const Recordings& recordings() const { return recordings_; }
  bool finish_recordings() { return recordings_.finish(); }
  // Until turn() may have a snapshot to ask for, in real time; a day where none is.
  std::chrono::milliseconds until_snapshot() const;
  bool paused() const { return paused_; }

  // What came through it is over.
  void forget_connection(int connection);

 private:
  template <class Message>
  void handle_by_rule(const Sender& sender, const Message& message);
  // Answers with an error where it returns false.
  template <class Message>
  bool may(const Sender& sender, const Message& message);
  template <class Message>
  bool may_change_world(const Sender& sender, const Message& message);
  template <class Message>
  bool has_room(const Sender& sender, const Message& message);

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
  void handle(const Sender& sender, const protocol::Pose& pose) { streams_.take(sender, pose, now_); }
  void handle(const Sender& sender, const protocol::Spin& spin) { streams_.take(sender, spin, now_); }

  // Passes it to the simulation thread, if there is room.
  template <class Message, class What>
  void ask(const Sender& sender, const Message& message, What what);
  template <class What, class Message>
  void ask_for_state(const Sender& sender, const Message& message);
  NewEpoch begin_epoch();

  // What has come back, where it means more than an answer.
  template <class What>
  void take_in(What&, const Acknowledgement&) {}
  void take_in(request::Pause&, const Acknowledgement&) { paused_ = true; }
  void take_in(request::Resume&, const Acknowledgement&) { paused_ = false; }
  void take_in(request::Hash&, const Acknowledgement&) { copying_ = false; }
  void take_in(request::Snapshot&, const Acknowledgement&) { copying_ = false; }
  void take_in(request::DueSnapshot& snapshot, const Acknowledgement& acknowledgement);
  void take_in(request::ReplaceWorld& replacement, const Acknowledgement& acknowledgement);
  void take_in(request::Record& recording, const Acknowledgement& acknowledgement);

  template <class What>
  void answer(const Sender& sender, What&, const protocol::Standing& standing, const Model&) {
    answers_.send(sender, protocol::Done{standing});
  }
  void answer(const Sender& sender, request::Hash& hash, const protocol::Standing& standing, const Model& model);
  void answer(const Sender& sender, request::Snapshot& snapshot, const protocol::Standing& standing,
              const Model& model);
  void answer(const Sender& sender, request::Record& recording, const protocol::Standing& standing, const Model& model);

  void finish_loading();
  void finish_recording();
  double simulation_time() const;  // s
  void ask_for_due_snapshot();

  const RequestOptions options_;
  Link& link_;
  Answers& answers_;
  const IsOpen is_open_;
  const std::uint64_t instance_;  // of this start of the server
  ServedWorld world_;
  CommandStreams streams_;
  PendingRequests pending_;
  RateLimiter limit_, limit_of_all_;
  Clock::time_point now_;
  bool paused_;
  bool copying_ = false;  // a copy of the state is on its way to a client

  SceneLoader loader_;
  protocol::Load loading_;  // the request that the loader works on,
  Sender loading_for_;      // and whose it is

  Recordings recordings_;
  std::optional<std::pair<Sender, protocol::Standing>> recording_ends_for_;  // who waits for the file's end

  SnapshotFile snapshot_file_;
  bool snapshot_due_ = false;  // one for the file is on its way
  double last_snapshot_ = 0;   // s of simulation time
};

}  // namespace acus
