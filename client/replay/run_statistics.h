// SPDX-License-Identifier: MIT
// What a run was like: states received and lost, the rate that was held, late ticks, round trips, and the extremes of
// the forces.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/replay/latency.h"
#include "protocol/messages.h"

namespace acus::client {

// Largest values over a run. Axial means along the base's +x axis.
struct ForceExtremes {
  double push = 0;     // N, axial resistance against going in
  double pull = 0;     // N, axial resistance against coming out
  double lateral = 0;  // N, across the axis
  double torque = 0;   // N m
  double depth = 0;    // m of needle inside the tissue
};

struct NeedleRun {
  std::uint64_t states = 0;      // received
  std::uint64_t lost = 0;        // ticks between them that never came
  std::uint64_t epoch = 0;       // of all of them
  std::uint64_t first_tick = 0;  // received
  std::uint64_t last_tick = 0;   // received
  std::uint64_t last_seq = 0;    // command in use at the last tick
  ForceExtremes extremes;
};

// A command that a state was the first to use.
struct CommandUse {
  std::uint64_t seq = 0;
  double received = 0;  // s, when that state came in
};

// From the sending of a pose to the first state that used it.
struct RoundTrip {
  std::uint64_t seq = 0;
  double sent = 0;     // s
  double seconds = 0;  // until the state came in
};

// How punctual the server was, by its own account.
struct Punctuality {
  std::uint64_t ticks = 0;
  std::uint64_t late = 0;  // of them, ended after the next one was due
  double wake_max = 0;     // s, largest from when a tick was due to when it began
  double end_p50 = 0;      // s from when a tick was due to its end, median of the newest `stats` with ticks
  double end_max = 0;      // s, largest
};

class RunStatistics {
 public:
  // Room for so many uses of commands, so that none is made while states come in.
  void reserve(std::size_t uses) { uses_.reserve(uses); }

  // `received` is in seconds on a clock of the caller. Throws Vanished when the world that the run began in is gone:
  // another epoch, or a tick that is not after the last one.
  void take(const protocol::Force& force, double received);
  void take(const protocol::Event& event);
  void take(const protocol::Stats& stats);

  const std::map<std::string, NeedleRun>& needles() const { return needles_; }
  const std::vector<CommandUse>& uses() const { return uses_; }
  std::uint64_t events() const { return events_; }
  std::uint64_t stats_received() const { return stats_received_; }

  std::uint64_t states() const;                            // received, of all needles
  std::uint64_t lost() const;                              // of all needles
  double last_received() const { return last_received_; }  // s, when the newest force state came in
  double rate() const;               // Hz, ticks per second of wall time; 0 before two ticks came in
  std::uint64_t overruns() const;    // of the server between the first and the last `stats`
  std::uint64_t rejections() const;  // by the server between the first and the last `stats`
  const Punctuality& punctuality() const { return punctuality_; }  // after the first `stats`

  // How many force states had each flag, in the order of protocol::kFlagNames.
  const auto& flagged() const { return flagged_; }

  // How many force states come from each solver of the laws, in the order of protocol::kLawSolverNames.
  const auto& solved() const { return solved_; }

  // A time (s) at which the state of a tick typically comes in, the others a multiple of `period` (s) away: the median
  // of the first kArrivals states. The first force state must have come in.
  double typical_arrival(double period) const;
  static constexpr std::size_t kArrivals = 1000;

  // Of each pose that a state was the first to use; sent_at[i] (s) is when number first_seq + i left.
  std::vector<RoundTrip> round_trips(const std::vector<double>& sent_at, std::uint64_t first_seq) const;

 private:
  std::map<std::string, NeedleRun> needles_;
  std::vector<CommandUse> uses_;
  std::uint64_t events_ = 0;
  std::uint64_t stats_received_ = 0;
  std::array<std::uint64_t, protocol::kFlagNames.size()> flagged_{};
  std::array<std::uint64_t, protocol::kLawSolverNames.size()> solved_{};
  std::vector<double> arrivals_;  // s, of the first needle's first states
  Punctuality punctuality_;
  std::optional<protocol::Stats> first_stats_;
  std::optional<protocol::Stats> last_stats_;
  double first_received_ = 0;
  double last_received_ = 0;
};

}  // namespace acus::client
