// SPDX-License-Identifier: GPL-3.0-or-later
// The simulation thread: runs the world's ticks on absolute deadlines of CLOCK_MONOTONIC or, in lockstep, when a
// `step` request asks for them, and passes on what somebody listens to.
//
// In real time it never waits for anything but its next deadline; a state for which there is no room is dropped and
// counted. In lockstep time is the client's: it waits for requests, and for room, so that no state is lost.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>

#include "server/link.h"

namespace acus {

struct LoopOptions {
  bool lockstep = false;
  std::uint64_t max_ticks = std::numeric_limits<std::uint64_t>::max();  // after which the loop ends
};

class RealtimeLoop {
 public:
  RealtimeLoop(std::unique_ptr<LoadedScene> world, const LoopOptions& options, Link& link);

  // Returns when the link says stop, after a shutdown request, or after max_ticks.
  void run();

  std::uint64_t ticks() const { return ticks_; }  // run so far, over all epochs

 private:
  void run_on_deadlines();
  void run_on_requests();
  bool over() const;

  void take_requests();
  void handle(Request& request);
  void replace_world(Request& request);
  void acknowledge(const Request& request, std::unique_ptr<LoadedScene> retired = nullptr);

  void tick();
  void take_commands();
  void publish(double tick_seconds);
  void publish_forces(const TickReport& report);
  void publish_events(const TickReport& report);
  void publish_tick(const TickReport& report, double tick_seconds);
  void publish_needles(const TickReport& report);
  void publish_tissue(const TickReport& report);
  void pack_paths(protocol::TissueShape& shape);

  // Room for one more; null if there is none and it must be dropped, which is counted.
  template <class T>
  T* room_in(SpscQueue<T>& queue);

  std::unique_ptr<LoadedScene> world_;
  const LoopOptions options_;
  Link& link_;
  std::array<const EpochCommand*, kMaxBodies> taken_{};  // commands for an epoch that has not begun yet
  std::uint64_t epoch_ = 0;
  std::uint64_t ticks_ = 0;
  bool paused_ = false;
  bool shut_down_ = false;
};

}  // namespace acus
