// SPDX-License-Identifier: GPL-3.0-or-later
// Runs a trajectory through a simulation as fast as it goes, with the clock beside it, and the calibration in between:
// blocks of ticks and of calibration runs take turns, so that both see the same drift of the machine. Each block begins
// with some that are not counted, since the block before has put its own data into the caches.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "server/engine/state/report.h"
#include "tests/study/bench/calibration.h"
#include "tests/study/bench/trajectory_driver.h"

namespace acus {

struct MeasurementPlan {
  static constexpr std::uint64_t kTicksPerBlock = 200;
  static constexpr std::uint64_t kUncountedTicks = 5;
  static constexpr int kSolvesPerBlock = 20;
  static constexpr int kUncountedSolves = 4;

  std::uint64_t max_ticks = std::numeric_limits<std::uint64_t>::max();  // of each time through the trajectory
  int repeat = 1;                                                       // times through it, >= 1
  double skip = 0;                                                      // s at its start that are not counted
  int min_rows = 0;                                                     // ticks with less rows are not counted
};

// How long something took (s).
struct Span {
  double wall = 0;
  double processor = 0;  // of this thread: without what other programs took of the core
};

struct Spans {
  std::vector<double> wall, processor;

  void reserve(std::size_t count);
  void add(const Span& span);
};

// Times in seconds of the ticks that count, in their order.
struct TickTimes {
  Spans whole;
  std::array<std::vector<double>, kStageCount> stages;
  std::vector<double> laws;  // stages compliance and solve together

  void reserve(std::size_t ticks);
  void add(const Span& tick, const std::array<double, kStageCount>& stage_seconds);
};

// What a tick that counts had to do; its times are those of the same place in TickTimes.
struct TickWork {
  std::uint64_t tick = 0;  // of its time through the trajectory
  int rows = 0;
  int solutions = 0;  // of the equations of motion, with their laws
  LawSteps laws;
  double residual = 0;  // N
  std::uint32_t flags = 0;
};

// Ticks that raised a flag, by its bit.
using FlagCounts = std::array<std::uint64_t, 32>;

struct Measurement {
  std::uint64_t ticks = 0;  // of all that were run, as everything but the times, rows and sweeps
  TickTimes times;
  std::vector<double> rows;    // of the ticks that count
  std::vector<double> sweeps;  // likewise
  std::vector<TickWork> work;  // likewise
  std::uint64_t allocations = 0;
  FlagCounts flags{};
  double residual_max = 0;     // N
  double imbalance_max = 0;    // N
  double imbalance_share = 0;  // -, imbalance_max over the largest force of the same tick
  // The calibration's runs that count; empty where there is none.
  Spans solves, default_order_solves, reads, dense_factorisations;
};

// What the ticks are compared with, as far as it is wanted and there is tissue to solve for.
struct Calibration {
  Calibration() = default;  // nothing
  explicit Calibration(const Simulation& simulation);

  std::optional<CholmodSolve> solve;          // in the order of elimination of the simulation: what ratios refer to
  std::optional<CholmodSolve> default_order;  // in CHOLMOD's own
  std::optional<TwoReads> reads;              // of the simulation's factor
  std::optional<DenseCholesky> dense;
};

// `progress` is told how many ticks of how many are done, between blocks.
using BlockProgress = std::function<void(std::uint64_t done, std::uint64_t of)>;

Measurement measure(Simulation& simulation, TrajectoryDriver& driver, Calibration& calibration,
                    const MeasurementPlan& plan, const BlockProgress& progress);

}  // namespace acus
