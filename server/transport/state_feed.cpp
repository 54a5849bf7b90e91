// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/state_feed.h"

#include <variant>

#include "server/engine/state/bytes/state_bytes.h"

namespace acus {
namespace {

using std::chrono::milliseconds;

constexpr int kRecordsPerTurn = 1024;
constexpr auto kStatsPeriod = milliseconds(1000);
constexpr auto kFirstStatsPeriod = milliseconds(20);  // from when somebody listens to them

}  // namespace

StateFeed::StateFeed(zmq::context_t& context, const std::string& endpoint, const Admission& admission, bool lockstep,
                     Link& link, ForClients for_clients)
    : link_(link),
      publisher_(context, endpoint, admission, lockstep),
      for_clients_(std::move(for_clients)),
      lockstep_(lockstep),
      begun_(Clock::now()),
      period_(kStatsPeriod) {}

// The first to listen to stats gets them soon: they are how a client sees that its subscriptions have arrived, and how
// long ticks take, so there have to be some.
void StateFeed::update_wanted() {
  const bool had_listener = wanted_ & bit(Topic::stats);
  wanted_ = publisher_.update_subscriptions();
  link_.wanted.store(wanted_, std::memory_order_relaxed);
  if (had_listener || !(wanted_ & bit(Topic::stats))) return;
  period_ = std::chrono::ceil<milliseconds>(Clock::now() - begun_) + kFirstStatsPeriod;
}

void StateFeed::pass_on(const ServedWorld& world) { all_sent_ = pass_on_records(world); }

// True if nothing is left that the simulation thread said.
bool StateFeed::pass_on_records(const ServedWorld& world) {
  for (int i = 0; i < kRecordsPerTurn; ++i) {
    blocked_ = !publisher_.flush();
    if (blocked_) return false;
    Record* record = link_.records.readable();
    if (!record) return pass_on_frames(world.published());
    // An answer comes after all states before it.
    if (std::holds_alternative<Acknowledgement>(*record) && !pass_on_frames(world.published())) return false;
    pass_on(*record, world.published());
    link_.records.release();
  }
  return false;
}

void StateFeed::pass_on(Record& record, const LoadedScene& world) {
  if (auto* acknowledgement = std::get_if<Acknowledgement>(&record)) {
    for_clients_.acknowledged(*acknowledgement);
  } else if (const auto* force = std::get_if<ForceRecord>(&record)) {
    publisher_.publish(*force, world);
  } else if (const auto* event = std::get_if<EventRecord>(&record)) {
    publisher_.publish(*event, world);
  } else if (const auto* haptics = std::get_if<HapticRecord>(&record)) {
    publisher_.publish(*haptics, world);
  } else if (const auto* beyond = std::get_if<LimitRecord>(&record)) {
    for_clients_.limited(*beyond);
  } else {
    statistics_.add(std::get<TickRecord>(record));
  }
}

bool StateFeed::pass_on_frames(LoadedScene& world) {
  while (!(blocked_ = !publisher_.flush())) {
    if (NeedleFrame* needle = world.needle_frames.readable()) {
      publisher_.publish(*needle, world);
      world.needle_frames.release();
    } else if (protocol::TissueShape* tissue = world.tissue_frames.readable()) {
      publisher_.publish(*tissue);
      world.tissue_frames.release();
    } else {
      return true;
    }
  }
  return false;
}

void StateFeed::publish_stats(const ServedWorld& world, const Standing& standing) {
  const Clock::time_point now = Clock::now();
  const std::chrono::duration<double> period = now - begun_;
  if (period < period_ || blocked_) return;
  const bool running = !standing.paused && !lockstep_;
  if (running && statistics_.ticks() == 0 && period < kStatsPeriod) {  // the loop is about to begin
    period_ += kFirstStatsPeriod;
    return;
  }
  begun_ = now;
  period_ = kStatsPeriod;
  protocol::Stats stats = statistics_.take();
  if (!(wanted_ & bit(Topic::stats))) return;
  stats.epoch = link_.epoch.load(std::memory_order_relaxed);
  stats.tick = link_.tick.load(std::memory_order_relaxed);
  stats.time = static_cast<double>(stats.tick) * world.published().hello.time_step;
  stats.period = period.count();
  stats.paused = standing.paused;
  stats.overruns = link_.overruns.load(std::memory_order_relaxed);
  stats.rejected = standing.rejected;
  stats.dropped = dropped();
  stats.recording = standing.recording;
  add_hash(world, stats);
  for (int i = 0; i < kTopicCount; ++i) {
    if (wanted_ & bit(static_cast<Topic>(i))) stats.subscribed.push_back(kTopicNames[i]);
  }
  publisher_.publish(stats);
}

// Of the newest state at a full second.
void StateFeed::add_hash(const ServedWorld& world, protocol::Stats& stats) const {
  StateBox& second = world.published().second;
  if (!second.full.load(std::memory_order_acquire)) return;
  if (second.epoch == stats.epoch) stats.hash_tick = second.state.tick, stats.hash = comparable_hash(second.state);
  second.full.store(false, std::memory_order_release);
}

}  // namespace acus
