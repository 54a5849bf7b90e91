// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/realtime_loop.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/runtime/clock.h"
#include "server/runtime/convert.h"
#include "server/runtime/deadline.h"

namespace acus {
namespace {

constexpr std::int64_t kRoomPoll = 50'000;  // ns between two looks for room, in lockstep
constexpr int kIdleCheck = 100;             // ms between two looks at the stop flag without a request, in lockstep
constexpr std::int64_t kNear = 50'000'000;  // ns to a deadline, for which nothing but the clock is looked at
constexpr int kIdleSlice = 20;              // ms between two looks at the stop flag on the way to a far deadline
constexpr std::uint32_t kGaveWay = kStepsCapped | kIterationsCapped | kPublishingReduced;

double seconds_between(std::int64_t from, std::int64_t to) { return static_cast<double>(to - from) / kNanoseconds; }

std::int64_t period_of(const LoadedScene& world) {
  return std::max<std::int64_t>(1, std::llround(kNanoseconds / world.simulation.scene().rate));
}

OverrunPolicy overrun_policy_of(const LoadedScene& world) {
  return OverrunPolicy(std::llround(kNanoseconds * world.simulation.scene().overrun.recovery));
}

// In lockstep no client is late: the world waits.
CommandLimits command_limits_of(const LoadedScene& world, bool lockstep) {
  const Clients& clients = world.simulation.scene().clients;
  return {world.hello.time_step, lockstep ? kInfinity : clients.stale_after, clients.ramp};
}

}  // namespace

RealtimeLoop::RealtimeLoop(std::unique_ptr<LoadedScene> world, const LoopOptions& options, Link& link)
    : world_(std::move(world)),
      options_(options),
      link_(link),
      overrun_(overrun_policy_of(*world_)),
      thinning_(world_->simulation.scene().overrun.publish_every),
      paused_(options.paused) {
  link_.tick.store(world_->simulation.report().tick, std::memory_order_relaxed);
  watch_commands();
}

void RealtimeLoop::run() {
  if (options_.lockstep) {
    run_on_requests();
  } else {
    run_on_deadlines();
  }
  link_.finished.store(true, std::memory_order_release);
  link_.to_sockets.signal();
}

bool RealtimeLoop::over() const {
  return shut_down_ || ticks_ >= options_.max_ticks || link_.stop.load(std::memory_order_relaxed);
}

void RealtimeLoop::run_on_deadlines() {
  std::int64_t due = monotonic_now();
  while (!over()) {
    wait_until(due);
    const std::int64_t woke = monotonic_now();
    take_requests();
    const std::int64_t begun = processor_now();
    const bool ticking = !paused_ && !over();
    const double computing = ticking ? tick() : 0;
    const double work = seconds_between(begun, processor_now());
    const std::int64_t ended = monotonic_now();
    const Deadline next = next_deadline(due, period_of(*world_), ended);
    link_.overruns.fetch_add(next.skipped, std::memory_order_relaxed);
    const TickTiming timing{computing, work, seconds_between(due, woke), seconds_between(due, ended), next.skipped > 0};
    if (ticking) keep_time(timing, ended);
    due = next.time;
  }
}

// A deadline far ahead leaves time for requests, and for a signal to end; it comes back at once when the loop is over.
void RealtimeLoop::wait_until(std::int64_t due) {
  while (due - monotonic_now() > kNear) {
    link_.to_simulation.wait(kIdleSlice);
    take_requests();
    if (over()) return;
  }
  sleep_until(due);
}

// What the tick that ended at `now` means for those to come. One that was late for want of a processor, not for its own
// work, would have been late with less to do, too.
void RealtimeLoop::keep_time(const TickTiming& timing, std::int64_t now) {
  publish_tick(timing);
  punctuality_.woke.add(timing.woke);
  punctuality_.ended.add(timing.ended);
  punctuality_.late += timing.late ? 1 : 0;
  punctuality_.economized += flags(world_->simulation.report()) & kGaveWay ? 1 : 0;
  const bool overran = timing.overran(world_->hello.time_step);
  world_->simulation.economize(overrun_.update(now, overran));
  thinning_.end(overran);
}

void RealtimeLoop::run_on_requests() {
  while (!over()) {
    link_.to_simulation.wait(kIdleCheck);
    take_requests();
  }
}

// A request waits until there is room for its acknowledgement, which must not be lost.
void RealtimeLoop::take_requests() {
  link_.turns.fetch_add(1, std::memory_order_relaxed);
  while (Request* request = link_.requests.readable()) {
    if (!link_.records.writable() || over()) return;
    handle(*request);
    link_.requests.release();
  }
}

void RealtimeLoop::handle(Request& request) {
  handled_ = request.id;
  std::visit([this](auto& what) { carry_out(what); }, request.what);
  acknowledge(request);
}

void RealtimeLoop::carry_out(request::Pause&) { paused_ = true; }
void RealtimeLoop::carry_out(request::Resume&) { paused_ = false; }
void RealtimeLoop::carry_out(request::Shutdown&) { shut_down_ = true; }
void RealtimeLoop::carry_out(request::Hash& hash) { *hash.state = world_->simulation.state(); }
void RealtimeLoop::carry_out(request::Snapshot& snapshot) { *snapshot.state = world_->simulation.state(); }
void RealtimeLoop::carry_out(request::DueSnapshot& snapshot) { *snapshot.state = world_->simulation.state(); }

void RealtimeLoop::carry_out(request::Reset& reset) {
  world_->simulation.reset();
  begin_epoch(reset.epoch);
}

void RealtimeLoop::carry_out(request::Restore& restore) {
  world_->simulation.restore(*restore.state);
  begin_epoch(restore.epoch);
}

void RealtimeLoop::carry_out(request::ReplaceWorld& replacement) {
  std::swap(world_, replacement.world);
  begin_epoch(replacement.epoch);
  watch_commands();
}

void RealtimeLoop::carry_out(request::Record& recording) {
  recorder_ = recording.recorder;
  record_epoch(recording.box);
}

// Goes no further when its client is gone.
void RealtimeLoop::carry_out(request::Step& step) {
  const auto abandoned = [this] { return link_.abandoned.load(std::memory_order_relaxed) == handled_; };
  for (std::uint32_t i = 0; i < step.ticks && !over() && !abandoned(); ++i) {
    const double computing = tick();
    publish_tick({.computing = computing, .ended = computing});
  }
}

// The simulation does not economise: it has just been loaded, reset or restored.
void RealtimeLoop::begin_epoch(NewEpoch& next) {
  epoch_ = next.number;
  overrun_ = overrun_policy_of(*world_);
  thinning_ = ShapeThinning(world_->simulation.scene().overrun.publish_every);
  for (CommandMonitor& watch : monitors_) watch.begin_epoch();
  origins_.assign(monitors_.size(), {});
  record_epoch(next.box);
}

// Of a world that none was watched for yet.
void RealtimeLoop::watch_commands() {
  const auto bodies = static_cast<std::size_t>(world_->body_count());
  monitors_.assign(bodies, CommandMonitor(command_limits_of(*world_, options_.lockstep)));
  origins_.assign(bodies, {});
}

void RealtimeLoop::acknowledge(Request& request) {
  const TickReport& report = world_->simulation.report();
  link_.epoch.store(epoch_, std::memory_order_relaxed);
  link_.tick.store(report.tick, std::memory_order_relaxed);
  if (Record* record = room_in(link_.records)) {
    *record = Acknowledgement{std::move(request), epoch_, report.tick, report.time, world_.get()};
    link_.records.commit();
  }
  link_.to_sockets.signal();
}

// ---- Recording ----

void RealtimeLoop::record_epoch(std::unique_ptr<StateBox>& box) {
  if (!recorder_ || !box) return;
  box_ = box.get();
  box_->state = world_->simulation.state();
  box_->full.store(true, std::memory_order_relaxed);
  record(EpochBegun{epoch_, world_->recorded, std::move(box)});
}

// The tick that was just made. A second whose state the recorder still holds is left out.
void RealtimeLoop::record_tick(bool economizing) {
  if (!recorder_) return;
  const TickReport& report = world_->simulation.report();
  record(recorded::Tick{report.tick, digest(hasher_, report), economizing});
  if (report.tick % world_->second_ticks != 0 || box_->full.load(std::memory_order_acquire)) return;
  box_->state = world_->simulation.state();
  box_->full.store(true, std::memory_order_relaxed);
  record(SecondOver{});
}

// In real time a recording with a gap is none: it ends there.
void RealtimeLoop::record(RecorderItem&& item) {
  if (!recorder_) return;
  RecorderItem* room = wait_for_room(recorder_->queue());
  if (!room) {
    recorder_->give_up();
    recorder_ = nullptr;
    return;
  }
  *room = std::move(item);
  recorder_->queue().commit();
}

// ---- Ticks ----

// Returns the time it took to compute (s).
double RealtimeLoop::tick() {
  link_.turns.fetch_add(1, std::memory_order_relaxed);
  take_commands();
  const bool economizing = world_->simulation.state().economizing;
  const std::int64_t begin = monotonic_now();
  world_->simulation.step();
  const double computing = seconds_between(begin, monotonic_now());
  ++ticks_;
  link_.tick.store(world_->simulation.report().tick, std::memory_order_relaxed);
  record_tick(economizing);
  publish();
  return computing;
}

// A command for an earlier epoch is forgotten; one for a later epoch overtook the request that begins it, and waits.
bool RealtimeLoop::take_command(int body) {
  const auto i = static_cast<std::size_t>(body);
  if (const EpochCommand* fresh = link_.commands[i].take()) taken_[i] = fresh;
  if (!taken_[i] || taken_[i]->epoch > epoch_) return false;
  const EpochCommand& taken = *std::exchange(taken_[i], nullptr);
  if (taken.epoch != epoch_ || body >= world_->body_count()) return false;
  if (taken.abandoned) {
    monitors_[i].abandon();
    return false;
  }
  origins_[i] = taken.origin;
  Command command = taken.command;
  if (!allow(body, command)) return false;
  if (world_->simulation.command(body, command)) record(recorded::BodyCommand{body, command});
  return true;
}

// False for a pose that is further away than the scene allows, and therefore ignored; else it is put within that.
bool RealtimeLoop::allow(int body, Command& command) {
  const Clients& clients = world_->simulation.scene().clients;
  const StepLimits limits{clients.max_step.value_or(kInfinity), clients.max_turn.value_or(kInfinity),
                          clients.beyond == Beyond::reject};
  const Acceptance acceptance = limit(limits, world_->simulation.motion(body).pose, command);
  if (acceptance == Acceptance::whole) return true;
  monitors_[static_cast<std::size_t>(body)].limit();
  if (Record* record = room_in(link_.records)) {
    *record = LimitRecord{epoch_, command.seq, body, acceptance};
    link_.records.commit();
    link_.to_sockets.signal();
  }
  return acceptance == Acceptance::clamped;
}

// A body whose client has fallen silent, or is gone, comes to rest.
void RealtimeLoop::take_commands() {
  const bool refused = (world_->simulation.report().flags & kNotFinite) != 0;  // with what it had been told
  for (int body = 0; body < kMaxBodies; ++body) {
    const bool fresh = take_command(body);
    if (body >= world_->body_count()) continue;
    CommandMonitor& watch = monitors_[static_cast<std::size_t>(body)];
    if (watch.tick(fresh) || (refused && watch.stale()))
      record(recorded::BodyCommand{body, world_->simulation.come_to_rest(body)});
  }
}

// Forces first: the socket thread sends them while shapes are packed here.
void RealtimeLoop::publish() {
  const TopicSet wanted = link_.wanted.load(std::memory_order_relaxed);
  const TickReport& report = world_->simulation.report();
  const TopicSet shapes = thinning_.begin(wanted & due_shapes(report.tick));
  if (wanted & bit(Topic::force)) publish_forces(report);
  if (wanted & bit(Topic::event)) publish_events(report);
  if (wanted & (bit(Topic::force) | bit(Topic::event))) link_.to_sockets.signal();
  if (wanted & bit(Topic::haptics)) publish_haptics(report);
  if (shapes) publish_shapes(shapes);
  if (wanted & bit(Topic::stats)) keep_full_second(report);
}

// For the other thread to hash; left out if that one has not come to the last yet.
void RealtimeLoop::keep_full_second(const TickReport& report) {
  StateBox& second = world_->second;
  if (report.tick % world_->second_ticks != 0 || second.full.load(std::memory_order_acquire)) return;
  second.epoch = epoch_;
  second.state = world_->simulation.state();
  second.full.store(true, std::memory_order_release);
}

TopicSet RealtimeLoop::due_shapes(std::uint64_t tick) const {
  const bool needles = tick % world_->needle_frame_ticks == 0, tissue = tick % world_->tissue_frame_ticks == 0;
  return (needles ? bit(Topic::needle) : 0) | (tissue ? bit(Topic::tissue) : 0);
}

// With what the loop, not the simulation, left out.
std::uint32_t RealtimeLoop::flags(const TickReport& report) const {
  return thinning_.left_out() ? report.flags | kPublishingReduced : report.flags;
}

ForceRecord RealtimeLoop::force_record(std::size_t needle) const {
  const TickReport& report = world_->simulation.report();
  return {epoch_,
          report.tick,
          report.time,
          origins_[needle],
          monitors_[needle],
          flags(report),
          report.solver,
          static_cast<int>(needle),
          report.needles[needle]};
}

void RealtimeLoop::publish_forces(const TickReport& report) {
  for (std::size_t i = 0; i < report.needles.size(); ++i) {
    Record* record = room_in(link_.records);
    if (!record) continue;
    *record = force_record(i);
    link_.records.commit();
  }
}

void RealtimeLoop::publish_haptics(const TickReport& report) {
  const std::span<const BaseStiffness> stiffnesses = world_->simulation.base_stiffnesses();
  for (std::size_t i = 0; i < report.needles.size(); ++i) {
    Record* record = room_in(link_.records);
    if (!record) continue;
    *record = HapticRecord{force_record(i), stiffnesses[i]};
    link_.records.commit();
  }
  link_.to_sockets.signal();
}

void RealtimeLoop::publish_events(const TickReport& report) {
  for (const Event& event : report.events) {
    Record* record = room_in(link_.records);
    if (!record) continue;
    *record = EventRecord{epoch_, report.time, event};
    link_.records.commit();
  }
}

void RealtimeLoop::publish_tick(const TickTiming& timing) {
  const TopicSet wanted = link_.wanted.load(std::memory_order_relaxed);
  if (!(wanted & bit(Topic::stats))) return;
  Record* record = room_in(link_.records);
  if (!record) return;
  const TickReport& report = world_->simulation.report();
  *record = TickRecord{timing,          flags(report),    report.rows,         report.sweeps, report.newton_iterations,
                       report.residual, report.imbalance, report.largest_force};
  link_.records.commit();
  if (!(wanted & bit(Topic::force))) link_.to_sockets.signal();  // else it goes along with the next force
}

void RealtimeLoop::publish_shapes(TopicSet topics) {
  if (topics & bit(Topic::needle)) publish_needles();
  if (topics & bit(Topic::tissue)) publish_tissue();
  link_.to_sockets.signal();
}

void RealtimeLoop::publish_needles() {
  for (int i = 0; i < static_cast<int>(world_->hello.needles.size()); ++i) {
    NeedleFrame* frame = room_in(world_->needle_frames);
    if (!frame) continue;
    frame->needle = i;
    frame->shape.epoch = epoch_;
    put(world_->simulation, i, frame->shape);
    world_->needle_frames.commit();
  }
}

void RealtimeLoop::publish_tissue() {
  protocol::TissueShape* shape = room_in(world_->tissue_frames);
  if (!shape) return;
  shape->epoch = epoch_;
  put(world_->simulation, world_->drawn, *shape);
  world_->tissue_frames.commit();
}

template <class T>
T* RealtimeLoop::wait_for_room(SpscQueue<T>& queue) {
  T* room = queue.writable();
  while (!room && options_.lockstep && !link_.stop.load(std::memory_order_relaxed)) {
    link_.turns.fetch_add(1, std::memory_order_relaxed);
    link_.to_sockets.signal();
    sleep_until(monotonic_now() + kRoomPoll);
    room = queue.writable();
  }
  return room;
}

template <class T>
T* RealtimeLoop::room_in(SpscQueue<T>& queue) {
  T* room = wait_for_room(queue);
  if (!room) link_.dropped.fetch_add(1, std::memory_order_relaxed);
  return room;
}

}  // namespace acus
