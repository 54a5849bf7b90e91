// SPDX-License-Identifier: GPL-3.0-or-later
// The simulation thread: runs the world's ticks on absolute deadlines of CLOCK_MONOTONIC or, in lockstep, when a
// `step` request asks for them, and passes on what somebody listens to.
//
// In real time it never waits for anything but its next deadline, and answers requests meanwhile where that is far; a
// state for which there is no room is dropped and counted. When a tick's own work is too much, what the scene's
// `overrun` allows is reduced. In lockstep time is the client's: it waits for requests, and for room, so
// that no state is lost.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>

#include "server/runtime/delay_histogram.h"
#include "server/runtime/link.h"
#include "server/runtime/overrun_policy.h"
#include "server/runtime/shape_thinning.h"

namespace acus {

struct LoopOptions {
  bool lockstep = false;
  bool paused = false;                                                  // until `resume`; not in lockstep
  std::uint64_t max_ticks = std::numeric_limits<std::uint64_t>::max();  // after which the loop ends
};

// How punctual a run in real time was, all its ticks together.
struct Punctuality {
  DelayHistogram woke;           // s from when a tick was due to when it began
  DelayHistogram ended;          // s from when a tick was due to when all it had to say was handed on
  std::uint64_t late = 0;        // ticks that ended after the next one was due
  std::uint64_t economized = 0;  // ticks in which something gave way, as their flags say
};

class RealtimeLoop {
 public:
  RealtimeLoop(std::unique_ptr<LoadedScene> world, const LoopOptions& options, Link& link);

  // Returns when the link says stop, after a shutdown request, or after max_ticks.
  void run();

  std::uint64_t ticks() const { return ticks_; }  // run so far, over all epochs
  const Punctuality& punctuality() const { return punctuality_; }

 private:
  void run_on_deadlines();
  void wait_until(std::int64_t due);
  void run_on_requests();
  bool over() const;

  void take_requests();
  void handle(Request& request);
  void carry_out(request::Pause&);
  void carry_out(request::Resume&);
  void carry_out(request::Reset& reset);
  void carry_out(request::ReplaceWorld& replacement);
  void carry_out(request::Restore& restore);
  void carry_out(request::Hash& hash);
  void carry_out(request::Snapshot& snapshot);
  void carry_out(request::DueSnapshot& snapshot);
  void carry_out(request::Record& recording);
  void carry_out(request::Step& step);
  void carry_out(request::Shutdown&);
  void begin_epoch(NewEpoch& next);
  void record_epoch(std::unique_ptr<StateBox>& box);
  void record_tick(bool economizing);
  void record(RecorderItem&& item);
  void watch_commands();
  void acknowledge(Request& request);

  double tick();
  void take_commands();
  bool take_command(int body);
  bool allow(int body, Command& command);
  void keep_time(const TickTiming& timing, std::int64_t now);
  void publish();
  ForceRecord force_record(std::size_t needle) const;
  void publish_forces(const TickReport& report);
  void publish_haptics(const TickReport& report);
  void publish_events(const TickReport& report);
  void publish_shapes(TopicSet topics);
  void publish_needles();
  void keep_full_second(const TickReport& report);
  void publish_tissue();
  void publish_tick(const TickTiming& timing);
  std::uint32_t flags(const TickReport& report) const;
  TopicSet due_shapes(std::uint64_t tick) const;

  // Room for one more; null if there is none, in lockstep only when the loop shall stop.
  template <class T>
  T* wait_for_room(SpscQueue<T>& queue);
  // The same; what has no room must be dropped, which is counted.
  template <class T>
  T* room_in(SpscQueue<T>& queue);

  std::unique_ptr<LoadedScene> world_;
  const LoopOptions options_;
  Link& link_;
  std::vector<CommandMonitor> monitors_;                 // per needle, then per guide
  std::vector<CommandOrigin> origins_;                   // likewise, of the newest command
  std::array<const EpochCommand*, kMaxBodies> taken_{};  // commands for an epoch that has not begun yet
  OverrunPolicy overrun_;
  ShapeThinning thinning_;
  Recorder* recorder_ = nullptr;  // if there is one,
  StateBox* box_ = nullptr;       // and its newest box
  Hasher hasher_;
  Punctuality punctuality_;
  std::uint64_t epoch_ = 0;
  std::uint64_t ticks_ = 0;
  std::uint64_t handled_ = 0;  // the request that is being carried out
  bool paused_;
  bool shut_down_ = false;
};

}  // namespace acus
