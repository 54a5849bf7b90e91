// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/bench/measurement.h"

#include <algorithm>
#include <chrono>
#include <string_view>

#include "server/engine/math/processor_time.h"
#include "tests/study/bench/allocation_count.h"

namespace acus {

namespace {

using Clock = std::chrono::steady_clock;
using Plan = MeasurementPlan;

constexpr auto kCompliance = static_cast<std::size_t>(Stage::compute_compliance);
constexpr auto kSolve = static_cast<std::size_t>(Stage::solve_laws);

// The processor's clock asks the kernel, and so stays outside of what the wall clock measures.
template <class Work>
Span time(const Work& work) {
  const double processor = processor_time();
  const Clock::time_point start = Clock::now();
  work();
  const double wall = std::chrono::duration<double>(Clock::now() - start).count();
  return {wall, processor_time() - processor};
}

template <class Calibrator>
void time_block(Calibrator& calibrator, Spans& spans) {
  for (int i = 0; i < Plan::kSolvesPerBlock; ++i) {
    const Span span = time([&] { calibrator.run(); });
    if (i >= Plan::kUncountedSolves) spans.add(span);
  }
}

void calibrate(Calibration& calibration, Measurement& result) {
  if (calibration.solve) time_block(*calibration.solve, result.solves);
  if (calibration.default_order) time_block(*calibration.default_order, result.default_order_solves);
  if (calibration.reads) time_block(*calibration.reads, result.reads);
  if (calibration.dense) time_block(*calibration.dense, result.dense_factorisations);
}

void count_flags(std::uint32_t flags, FlagCounts& counts) {
  for (std::size_t bit = 0; bit < counts.size(); ++bit) counts[bit] += flags >> bit & 1u;
}

Span step(Simulation& simulation, Measurement& result) {
  const AllocationCount allocations;
  const Span span = time([&] { simulation.step(); });
  result.allocations += static_cast<std::uint64_t>(allocations.value());
  return span;
}

void note(const TickReport& report, Measurement& result) {
  ++result.ticks;
  count_flags(report.flags, result.flags);
  result.residual_max = std::max(result.residual_max, report.residual);
  if (report.imbalance > result.imbalance_max) {
    result.imbalance_max = report.imbalance;
    result.imbalance_share = report.imbalance / report.largest_force;
  }
}

}  // namespace

void Spans::reserve(std::size_t count) {
  wall.reserve(count);
  processor.reserve(count);
}

void Spans::add(const Span& span) {
  wall.push_back(span.wall);
  processor.push_back(span.processor);
}

void TickTimes::reserve(std::size_t ticks) {
  whole.reserve(ticks);
  laws.reserve(ticks);
  for (std::vector<double>& stage : stages) stage.reserve(ticks);
}

void TickTimes::add(const Span& tick, const std::array<double, kStageCount>& stage_seconds) {
  whole.add(tick);
  for (std::size_t i = 0; i < stages.size(); ++i) stages[i].push_back(stage_seconds[i]);
  laws.push_back(stage_seconds[kCompliance] + stage_seconds[kSolve]);
}

Calibration::Calibration(const Simulation& simulation) {
  dense.emplace();
  const SparseMatrix matrix = tick_matrix(simulation);
  if (matrix.rows() == 0) return;
  solve.emplace(matrix, simulation_order(matrix));
  default_order.emplace(matrix);
  reads.emplace(simulation.costs().factor_bytes);
}

Measurement measure(Simulation& simulation, TrajectoryDriver& driver, Calibration& calibration, const Plan& plan,
                    const BlockProgress& progress) {
  const std::uint64_t ticks = std::min(driver.ticks(), plan.max_ticks);
  const std::uint64_t all = ticks * static_cast<std::uint64_t>(plan.repeat);
  const double skipped = plan.skip * simulation.scene().rate;
  Measurement result;
  result.times.reserve(all);
  result.work.reserve(all);
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
      const Span span = step(simulation, result);
      const TickReport& report = simulation.report();
      note(report, result);
      if (in_block < Plan::kUncountedTicks || static_cast<double>(tick) < skipped || report.rows < plan.min_rows)
        continue;
      result.times.add(span, simulation.stage_seconds());
      result.rows.push_back(report.rows);
      result.sweeps.push_back(report.sweeps);
      result.work.push_back(
          {report.tick, report.rows, report.newton_iterations, simulation.law_steps(), report.residual, report.flags});
    }
  }
  return result;
}

}  // namespace acus
