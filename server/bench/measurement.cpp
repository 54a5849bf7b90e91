// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/bench/measurement.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <string_view>

#include "server/bench/allocation_count.h"

namespace acus {

namespace {

using Clock = std::chrono::steady_clock;
using Plan = MeasurementPlan;

constexpr std::size_t kCompliance = 5, kSolve = 6;
static_assert(kStageNames[kCompliance] == std::string_view("compliance"));
static_assert(kStageNames[kSolve] == std::string_view("solve"));

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Of this thread (s).
double processor_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

template <class Work>
void time_block(Work& work, std::vector<double>& seconds) {
  for (int i = 0; i < Plan::kSolvesPerBlock; ++i) {
    const double start = processor_time();
    work.run();
    if (i >= Plan::kUncountedSolves) seconds.push_back(processor_time() - start);
  }
}

void calibrate(Calibration& calibration, Measurement& result) {
  if (calibration.standard) time_block(*calibration.standard, result.standard_solves);
  if (calibration.least_fill) time_block(*calibration.least_fill, result.least_fill_solves);
  if (calibration.dense) time_block(*calibration.dense, result.dense_factorisations);
}

void count_flags(std::uint32_t flags, FlagCounts& counts) {
  for (std::size_t bit = 0; bit < counts.size(); ++bit) counts[bit] += flags >> bit & 1u;
}

// The processor's clock asks the kernel, and so stays outside of what the wall clock measures.
StepTime step(Simulation& simulation, Measurement& result) {
  const AllocationCount allocations;
  StepTime time;
  const double processor = processor_time();
  const Clock::time_point start = Clock::now();
  simulation.step();
  time.wall = seconds_since(start);
  time.processor = processor_time() - processor;
  result.allocations += static_cast<std::uint64_t>(allocations.value());
  return time;
}

void note(const TickReport& report, Measurement& result) {
  ++result.ticks;
  count_flags(report.flags, result.flags);
  result.residual_max = std::max(result.residual_max, report.residual);
  result.imbalance_max = std::max(result.imbalance_max, report.imbalance);
}

}  // namespace

void TickTimes::reserve(std::size_t ticks) {
  whole.reserve(ticks);
  processor.reserve(ticks);
  laws.reserve(ticks);
  for (std::vector<double>& stage : stages) stage.reserve(ticks);
}

void TickTimes::add(const StepTime& step, const TickReport& report) {
  whole.push_back(step.wall);
  processor.push_back(step.processor);
  for (std::size_t i = 0; i < stages.size(); ++i) stages[i].push_back(report.stage_seconds[i]);
  laws.push_back(report.stage_seconds[kCompliance] + report.stage_seconds[kSolve]);
}

Calibration::Calibration(const Simulation& simulation) {
  dense.emplace();
  const SparseMatrix matrix = tick_matrix(simulation);
  if (matrix.rows() == 0) return;
  standard.emplace(matrix, Ordering::standard);
  least_fill.emplace(matrix, Ordering::least_fill);
}

Measurement measure(Simulation& simulation, TrajectoryDriver& driver, Calibration& calibration, const Plan& plan,
                    const BlockProgress& progress) {
  const std::uint64_t ticks = std::min(driver.ticks(), plan.max_ticks);
  const std::uint64_t all = ticks * static_cast<std::uint64_t>(plan.repeat);
  const auto skipped = static_cast<std::uint64_t>(plan.skip * simulation.scene().rate);
  Measurement result;
  result.times.reserve(all);
  simulation.time_stages(true);
  for (int pass = 0; pass < plan.repeat; ++pass) {
    simulation.reset();
    for (std::uint64_t tick = 0; tick < ticks; ++tick) {
      const std::uint64_t in_block = tick % Plan::kTicksPerBlock;
      if (in_block == 0) {
        progress(result.ticks, all);
        calibrate(calibration, result);
      }
      driver.command();
      const StepTime time = step(simulation, result);
      const TickReport& report = simulation.report();
      note(report, result);
      if (in_block < Plan::kUncountedTicks || tick < skipped || report.rows < plan.min_rows) continue;
      result.times.add(time, report);
      result.rows.push_back(report.rows);
      result.sweeps.push_back(report.sweeps);
    }
  }
  return result;
}

}  // namespace acus
