// SPDX-License-Identifier: MIT
// Drives a trajectory into a server and records the forces, and if asked the shapes, that come back.
//
// In real time, poses leave at a fixed rate on absolute deadlines of the steady clock, from a thread of their own, in
// step with the server's ticks: each shortly before the tick that is to use it. A deadline that was missed is skipped,
// never made up for. In lockstep, each pose is followed by one tick, so the same
// scene and trajectory give the same states, whatever the machine does besides.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/link/client.h"
#include "client/replay/run_log.h"
#include "client/replay/run_statistics.h"
#include "client/replay/shape_log.h"
#include "client/replay/trajectory.h"

namespace acus::client {

struct ReplayOptions {
  std::string commands = protocol::kDefaultCommandsEndpoint;
  std::string states = protocol::kDefaultStatesEndpoint;
  std::optional<CurveKeys> keys;  // for a server that asks for them
  std::optional<double> rate;  // Hz, > 0, of the poses of each needle; absent: the server's ticks per second
  int passes = 1;              // > 0, through the trajectory, every second one backwards
  bool lockstep = false;
  bool shutdown = false;                   // ask the server to end after the run
  Timeout timeout{10'000};                 // to wait for the server to appear, to answer, or to publish a state
  std::atomic<bool>* interrupt = nullptr;  // ends the run when it becomes true
  std::function<void(const protocol::Force&)> on_state;          // called with each force state that came in
  std::function<void(const protocol::Stats&, double)> on_stats;  // likewise, with s since the start of the run
};

// The trajectory does not fit the server: a needle or guide that the scene does not have, a guide that spins, or the
// other clock mode.
struct Unsuitable : ClientError {
  using ClientError::ClientError;
};

// ReplayOptions::interrupt became true.
struct Interrupted : ClientError {
  using ClientError::ClientError;
};

class Replay {
 public:
  // The logs may be null; they and `trajectory` must outlive the replay.
  Replay(const Trajectory& trajectory, const ReplayOptions& options, RunLog* log, ShapeLog* shapes);

  // Runs once, from hello to the last state. Throws ClientError or what stands below it; what was received until then
  // is in the logs and in the results below.
  void run();

  const protocol::HelloReply& server() const { return server_; }
  const RunStatistics& statistics() const { return statistics_; }
  std::vector<RoundTrip> round_trips() const { return statistics_.round_trips(sent_at_, first_seq_); }
  double transit() const { return transit_; }                   // s, to the server and back, without a tick; median
  std::uint64_t poses_sent() const { return sent_at_.size(); }  // per needle
  std::uint64_t deadlines_missed() const { return deadlines_missed_; }

 private:
  using Clock = std::chrono::steady_clock;

  void greet();
  void measure_transit();
  void subscribe();
  void await_first_states();
  void run_in_real_time();
  void run_in_lockstep();
  Clock::time_point first_departure() const;
  void send_poses_on_time(Clock::time_point begin, const std::atomic<bool>& stop);
  void send_poses(double time);
  void await_last_states();
  void step();

  // What the timeout bounds: the whole wait, or the silence between two states while another thread sends poses.
  enum class Patience { in_all, per_state };
  template <class Done>
  void receive_until(Done done, Patience patience, const std::string& awaited);
  void check_commands(bool receiving, const std::string& awaited);
  bool receive(Timeout timeout);
  void take(const protocol::State& state);
  void record(const protocol::NeedleShape& shape);
  void record(const protocol::TissueShape& shape);

  protocol::Pose pose_at(const Motion& motion, double time) const;
  bool is_guide(const Motion& motion) const;
  bool all_needles_seen() const { return statistics_.needles().size() == server_.needles.size(); }
  bool all_needles_at(std::uint64_t tick) const;
  bool last_poses_used() const;
  double now() const;  // s since the start of the run
  double rate() const { return options_.rate.value_or(server_.rate); }
  double duration() const { return options_.passes * pass_duration(); }
  double pass_duration() const { return trajectory_.end() - trajectory_.begin(); }
  double trajectory_time(double elapsed) const;

  const Trajectory& trajectory_;
  ReplayOptions options_;
  RunLog* log_;
  ShapeLog* shapes_;
  Clock::time_point start_ = Clock::now();
  CommandLink commands_;
  StateLink states_;
  protocol::HelloReply server_;
  double transit_ = 0;
  RunStatistics statistics_;
  std::uint64_t first_seq_ = 1;
  std::atomic<double> sent_time_;  // s, of the trajectory: of the newest poses that left, its begin before them
  std::vector<double> sent_at_;  // s since the start of the run; entry i is when the poses numbered first_seq_ + i left
  std::uint64_t deadlines_missed_ = 0;
};

}  // namespace acus::client
