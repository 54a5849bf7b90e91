// SPDX-License-Identifier: MIT
#include "client/replay/run_statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "client/link/client.h"

namespace acus::client {
namespace {

// About which times (s, not none) lie that recur with a period (s): the direction of their mean on a circle.
double middle_of(const std::vector<double>& times, double period) {
  const double turn = 2 * std::numbers::pi / period;
  double x = 0, y = 0;
  for (const double time : times) {
    x += std::cos(turn * (time - times.front()));
    y += std::sin(turn * (time - times.front()));
  }
  return times.front() + std::atan2(y, x) / turn;
}

double norm(const protocol::Vector3& v) { return std::hypot(v[0], v[1], v[2]); }

void widen(ForceExtremes& extremes, const protocol::Force& force) {
  const double resistance = -force.base_force_in_base[0];  // the holder is pushed back along -x when going in
  extremes.push = std::max(extremes.push, resistance);
  extremes.pull = std::max(extremes.pull, -resistance);
  extremes.lateral = std::max(extremes.lateral, std::hypot(force.base_force_in_base[1], force.base_force_in_base[2]));
  extremes.torque = std::max(extremes.torque, norm(force.base_torque));
  extremes.depth = std::max(extremes.depth, force.depth);
}

void widen(Punctuality& punctuality, const protocol::Stats& stats) {
  punctuality.ticks += stats.ticks;
  punctuality.late += stats.late;
  punctuality.wake_max = std::max(punctuality.wake_max, stats.wake_max);
  punctuality.end_max = std::max(punctuality.end_max, stats.end_max);
}

void begin(NeedleRun& run, const protocol::Force& force) {
  run.epoch = force.epoch;
  run.first_tick = force.tick;
  run.last_seq = force.seq;
}

void check_same_world(const NeedleRun& run, const protocol::Force& force) {
  if (force.epoch == run.epoch && force.tick > run.last_tick) return;
  throw Vanished("the world of this run is gone: the server was restarted, reset or given another scene at tick " +
                 std::to_string(run.last_tick));
}

}  // namespace

void RunStatistics::take(const protocol::Force& force, double received) {
  if (states() == 0) first_received_ = received;
  last_received_ = received;

  NeedleRun& run = needles_[force.needle];
  if (run.states == 0) {
    begin(run, force);
  } else {
    check_same_world(run, force);
    run.lost += force.tick - run.last_tick - 1;
  }
  if (force.seq != run.last_seq) uses_.push_back({force.seq, received});
  if (arrivals_.size() < kArrivals && force.needle == needles_.begin()->first) arrivals_.push_back(received);
  ++solved_[static_cast<std::size_t>(force.solver)];
  for (std::size_t bit = 0; bit < flagged_.size(); ++bit) flagged_[bit] += force.flags >> bit & 1u;
  ++run.states;
  run.last_tick = force.tick;
  run.last_seq = force.seq;
  widen(run.extremes, force);
}

void RunStatistics::take(const protocol::Event&) { ++events_; }

void RunStatistics::take(const protocol::Stats& stats) {
  ++stats_received_;
  if (first_stats_) widen(punctuality_, stats);
  if (stats.ticks > 0) punctuality_.end_p50 = stats.end_p50;
  if (!first_stats_) first_stats_ = stats;
  last_stats_ = stats;
}

std::uint64_t RunStatistics::states() const {
  std::uint64_t sum = 0;
  for (const auto& [name, run] : needles_) sum += run.states;
  return sum;
}

std::uint64_t RunStatistics::lost() const {
  std::uint64_t sum = 0;
  for (const auto& [name, run] : needles_) sum += run.lost;
  return sum;
}

double RunStatistics::rate() const {
  if (needles_.empty() || last_received_ <= first_received_) return 0;
  const NeedleRun& run = needles_.begin()->second;
  return static_cast<double>(run.last_tick - run.first_tick) / (last_received_ - first_received_);
}

std::uint64_t RunStatistics::overruns() const {
  return first_stats_ ? last_stats_->overruns - first_stats_->overruns : 0;
}

std::uint64_t RunStatistics::rejections() const {
  return first_stats_ ? last_stats_->rejected - first_stats_->rejected : 0;
}

// Offsets are told from the middle of all arrivals, so that few of them wrap round, whenever the first one came.
double RunStatistics::typical_arrival(double period) const {
  const double middle = middle_of(arrivals_, period);
  std::vector<double> offsets;
  offsets.reserve(arrivals_.size());
  for (const double arrival : arrivals_) offsets.push_back(std::remainder(arrival - middle, period));
  std::sort(offsets.begin(), offsets.end());
  return middle + percentile(offsets, 0.5);
}

std::vector<RoundTrip> RunStatistics::round_trips(const std::vector<double>& sent_at, std::uint64_t first_seq) const {
  std::vector<RoundTrip> trips;
  trips.reserve(uses_.size());
  for (const CommandUse& use : uses_) {
    const bool ours = use.seq >= first_seq && use.seq - first_seq < sent_at.size();
    if (!ours) continue;
    const double sent = sent_at[use.seq - first_seq];
    trips.push_back({use.seq, sent, use.received - sent});
  }
  return trips;
}

}  // namespace acus::client
