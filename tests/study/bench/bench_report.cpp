// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/bench/bench_report.h"

#include <array>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "client/replay/latency.h"
#include "protocol/messages.h"
#include "protocol/own_file.h"
#include "server/engine/math/kernel_set.h"
#include "server/engine/scene/scene_fields.h"
#include "server/engine/scene/text/text_table.h"
#include "server/engine/state/bytes/state_bytes.h"

namespace acus {

namespace {

using Json = nlohmann::ordered_json;  // writes null for what is not finite
using client::Distribution;
using protocol::kFlagNames;  // by the bits of TickReport::flags
static_assert(kBaseLimited == 1u << (kFlagNames.size() - 1));

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::string formatted(const char* format, double value) {
  if (!std::isfinite(value)) return "-";
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

const char* rung_name(const Simulation& simulation) {
  return NamesOf<TissueRung>::names[static_cast<std::size_t>(simulation.scene().tissue.rung)];
}
const char* solver_name(const Simulation& simulation) {
  return NamesOf<LawMethod>::names[static_cast<std::size_t>(simulation.scene().laws.solver)];
}

// Not numbers where there is nothing to tell of.
Distribution distribution_of(const std::vector<double>& values) {
  Distribution d = client::distribution_of(values);
  if (values.empty()) d.p50 = d.p99 = d.max = kUnknown;
  return d;
}

double median(const std::vector<double>& values) { return distribution_of(values).p50; }

// What the goals speak of, by one clock. Of processor times neighbours on the core neither spoil nor flatter them.
struct TickRatios {
  double to_calibration, to_reads, to_default_order, p99_to_p50;

  TickRatios(const Measurement& m, std::vector<double> Spans::*clock) {
    const Distribution tick = distribution_of(m.times.whole.*clock);
    to_calibration = tick.p50 / median(m.solves.*clock);
    to_reads = tick.p50 / median(m.reads.*clock);
    to_default_order = tick.p50 / median(m.default_order_solves.*clock);
    p99_to_p50 = tick.p99 / tick.p50;
  }
};

// Of the state that the run ends with: two builds with the same compute the same, and their times can be compared.
std::string state_hash(const Simulation& simulation) {
  std::array<char, 17> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%016" PRIx64, hash(simulation.state()));
  return buffer.data();
}

// Stages are measured by the wall clock alone.
double laws_to_dense(const Measurement& m) { return median(m.times.laws) / median(m.dense_factorisations.wall); }

// --------------------------------------------------------------------------------------------------------- table

std::string milliseconds(double seconds) { return formatted("%10.4f", 1e3 * seconds); }
std::string ratio(double value) { return formatted("%10.3f", value); }

std::string opening(const BenchRun& run, const Simulation& simulation) {
  const Measurement& m = run.measured;
  const Costs costs = simulation.costs();
  TextTable table;
  table.add({"scene", simulation.scene().name + ", " + run.scene_file});
  table.add({"motion", run.trajectory_file});
  table.add({"rung", std::string(rung_name(simulation)) + ", solver " + solver_name(simulation)});
  table.add({"mesh", std::to_string(simulation.mesh().node_count()) + " nodes (" + std::to_string(costs.free_nodes) +
                         " free), " + std::to_string(simulation.mesh().tetrahedron_count()) +
                         " tetrahedra, factor of " + std::to_string(costs.factor_entries) + " entries"});
  table.add({"load",
             formatted("%.2f s, ", run.load_seconds) + formatted("%.0f MiB at its peak", run.peak_memory / (1 << 20))});
  table.add({"core", std::to_string(run.core) + ", " + processor_name()});
  table.add({"kernels", std::string(name_of(kernel_set())) + ", of those that the processor has"});
  table.add({"ticks", std::to_string(m.ticks) + ", of which " + std::to_string(m.times.whole.wall.size()) +
                          " count for times, rows and sweeps"});
  table.add({"state hash", state_hash(simulation) + " at the end"});
  return table.text();
}

void add_times(TextTable& table, const std::string& name, const std::vector<double>& seconds) {
  const Distribution d = distribution_of(seconds);
  table.add({name, milliseconds(d.p50), milliseconds(d.p99), milliseconds(d.max)});
}

std::string times(const TickTimes& times) {
  TextTable table;
  table.add({"time (ms)", "       p50", "       p99", "       max"});
  for (std::size_t i = 0; i < times.stages.size(); ++i)
    add_times(table, std::string("  ") + kStageNames[i], times.stages[i]);
  add_times(table, "tick", times.whole.wall);
  add_times(table, "tick, processor time", times.whole.processor);
  add_times(table, "compliance + solve", times.laws);
  return table.text();
}

std::string fill(const CholmodSolve& solve) {
  return std::string(solve.ordering_name()) + ", " + std::to_string(solve.factor_entries()) + " entries";
}

void add_calibration(TextTable& table, const std::string& name, const Spans& spans, const std::string& size) {
  table.add({name, milliseconds(median(spans.wall)), milliseconds(median(spans.processor)), size});
}

std::string calibrations(const Measurement& m, const Calibration& calibration) {
  TextTable table;
  table.add({"calibration (ms), median", "      time", " processor", "size"});
  if (calibration.solve) add_calibration(table, "  CHOLMOD forward + backward", m.solves, fill(*calibration.solve));
  if (calibration.default_order)
    add_calibration(table, "  the same, default order", m.default_order_solves, fill(*calibration.default_order));
  if (calibration.reads)
    add_calibration(table, "  the factor read twice", m.reads,
                    formatted("%.1f MiB", calibration.reads->bytes() / (1 << 20)) +
                        formatted(", %.1f GB/s", 2e-9 * calibration.reads->bytes() / median(m.reads.wall)));
  if (calibration.dense)
    add_calibration(table, "  dense Cholesky", m.dense_factorisations, std::to_string(DenseCholesky::kRows) + " rows");
  return table.text();
}

std::string ratios(const Measurement& m) {
  const TickRatios wall(m, &Spans::wall), processor(m, &Spans::processor);
  TextTable table;
  table.add({"ratios", "      time", " processor"});
  table.add({"  tick p50 / calibration", ratio(wall.to_calibration), ratio(processor.to_calibration)});
  table.add({"  tick p50 / default order", ratio(wall.to_default_order), ratio(processor.to_default_order)});
  table.add({"  tick p50 / factor read twice", ratio(wall.to_reads), ratio(processor.to_reads)});
  table.add({"  tick p99 / p50", ratio(wall.p99_to_p50), ratio(processor.p99_to_p50)});
  table.add({"  compliance + solve p50 / dense", ratio(laws_to_dense(m))});
  return table.text();
}

std::string raised(const FlagCounts& counts) {
  std::string text;
  for (std::size_t bit = 0; bit < kFlagNames.size(); ++bit) {
    if (counts[bit] == 0) continue;
    if (!text.empty()) text += ", ";
    text += std::string(kFlagNames[bit]) + " in " + std::to_string(counts[bit]) + " ticks";
  }
  return text.empty() ? "none" : text;
}

std::string soundness(const Measurement& m) {
  const Distribution rows = distribution_of(m.rows), sweeps = distribution_of(m.sweeps);
  TextTable table;
  table.add({"rows", formatted("median %.0f, ", rows.p50) + formatted("most %.0f", rows.max)});
  table.add({"sweeps", formatted("median %.0f, ", sweeps.p50) + formatted("most %.0f", sweeps.max)});
  table.add({"heap allocations in ticks", std::to_string(m.allocations)});
  table.add({"largest residual of the laws", formatted("%.3g N", m.residual_max)});
  table.add({"largest imbalance of forces", formatted("%.3g N; ", m.imbalance_max) +
                                                formatted("%.2g", m.imbalance_share) +
                                                " of the largest force of its tick"});
  table.add({"flags", raised(m.flags)});
  return table.text();
}

// ---------------------------------------------------------------------------------------------------------- JSON

Json distribution(const std::vector<double>& seconds) {
  const Distribution d = distribution_of(seconds);
  return {{"p50_ms", 1e3 * d.p50}, {"p99_ms", 1e3 * d.p99}, {"max_ms", 1e3 * d.max}};
}

Json stages(const TickTimes& times) {
  Json json = Json::object();
  for (std::size_t i = 0; i < times.stages.size(); ++i) json[kStageNames[i]] = distribution(times.stages[i]);
  return json;
}

Json medians(const Spans& spans) {
  return {{"median_ms", 1e3 * median(spans.wall)}, {"processor_median_ms", 1e3 * median(spans.processor)}};
}

Json solve(const Spans& spans, const CholmodSolve& solve) {
  Json json = medians(spans);
  json["ordering"] = solve.ordering_name();
  json["factor_entries"] = solve.factor_entries();
  return json;
}

Json factor_reads(const Spans& spans, const TwoReads& reads) {
  Json json = medians(spans);
  json["bytes"] = 2 * reads.bytes();
  return json;
}

Json dense_cholesky(const Spans& spans) {
  Json json = medians(spans);
  json["rows"] = int{DenseCholesky::kRows};
  return json;
}

Json calibration_json(const Measurement& m, const Calibration& calibration) {
  Json json = Json::object();
  if (calibration.solve) json["simulation_order"] = solve(m.solves, *calibration.solve);
  if (calibration.default_order) json["default_order"] = solve(m.default_order_solves, *calibration.default_order);
  if (calibration.reads) json["factor_read_twice"] = factor_reads(m.reads, *calibration.reads);
  if (calibration.dense) json["dense_cholesky"] = dense_cholesky(m.dense_factorisations);
  return json;
}

Json tick_ratios(const TickRatios& r) {
  return {{"tick_p50_to_calibration", r.to_calibration},
          {"tick_p50_to_default_order", r.to_default_order},
          {"tick_p50_to_factor_read_twice", r.to_reads},
          {"tick_p99_to_p50", r.p99_to_p50}};
}

Json ratios_json(const Measurement& m) {
  Json wall = tick_ratios({m, &Spans::wall});
  wall["laws_p50_to_dense_cholesky"] = laws_to_dense(m);
  return {{"wall", wall}, {"processor", tick_ratios({m, &Spans::processor})}};
}

Json flags_json(const FlagCounts& counts) {
  Json json = Json::object();
  for (std::size_t bit = 0; bit < kFlagNames.size(); ++bit)
    if (counts[bit] > 0) json[std::string(kFlagNames[bit])] = counts[bit];
  return json;
}

// One list per quantity, with an entry per tick that counts, so that programs can find what the slow ones did.
Json each_tick(const Measurement& m) {
  const auto list = [&m](auto value) {
    Json values = Json::array();
    for (const TickWork& tick : m.work) values.push_back(value(tick));
    return values;
  };
  const auto milliseconds_of = [](const std::vector<double>& seconds) {
    Json values = Json::array();
    for (const double each : seconds) values.push_back(1e3 * each);
    return values;
  };
  Json stages = Json::object();
  for (std::size_t i = 0; i < m.times.stages.size(); ++i) stages[kStageNames[i]] = milliseconds_of(m.times.stages[i]);
  return {{"tick", list([](const TickWork& t) { return t.tick; })},
          {"ms", milliseconds_of(m.times.whole.wall)},
          {"processor_ms", milliseconds_of(m.times.whole.processor)},
          {"stages_ms", stages},
          {"rows", list([](const TickWork& t) { return t.rows; })},
          {"solutions", list([](const TickWork& t) { return t.solutions; })},
          {"rounds", list([](const TickWork& t) { return t.laws.rounds; })},
          {"sweeps", list([](const TickWork& t) { return t.laws.sweeps; })},
          {"picks", list([](const TickWork& t) { return t.laws.picks; })},
          {"interior_point_iterations", list([](const TickWork& t) { return t.laws.iterations; })},
          {"law_work", list([](const TickWork& t) { return t.laws.work; })},
          {"residual_N", list([](const TickWork& t) { return t.residual; })},
          {"flags", list([](const TickWork& t) { return t.flags; })}};
}

}  // namespace

HistoryRow history_row(const BenchRun& run, const Simulation& simulation) {
  const TickRatios ratios(run.measured, &Spans::processor);
  HistoryRow row;
  row.processor = processor_name();
  row.kernels = name_of(kernel_set());
  row.scene = std::filesystem::path(run.scene_file).stem().string();
  row.to_calibration = ratios.to_calibration;
  row.p99_to_p50 = ratios.p99_to_p50;
  row.state_hash = state_hash(simulation);
  return row;
}

std::string bench_table(const BenchRun& run, const Simulation& simulation, const Calibration& calibration) {
  const Measurement& m = run.measured;
  return opening(run, simulation) + "\n" + times(m.times) + "\n" + calibrations(m, calibration) + "\n" + ratios(m) +
         "\n" + soundness(m);
}

std::string bench_json(const BenchRun& run, const Simulation& simulation, const Calibration& calibration) {
  const Measurement& m = run.measured;
  const Distribution rows = distribution_of(m.rows), sweeps = distribution_of(m.sweeps);
  const Costs costs = simulation.costs();
  const Json json{
      {protocol::kWrittenBy, protocol::kWriter},
      {"scene", run.scene_file},
      {"trajectory", run.trajectory_file},
      {"rung", rung_name(simulation)},
      {"solver", solver_name(simulation)},
      {"rate", simulation.scene().rate},
      {"nodes", simulation.mesh().node_count()},
      {"tetrahedra", simulation.mesh().tetrahedron_count()},
      {"unknowns", 3 * costs.free_nodes},
      {"factor_entries", costs.factor_entries},
      {"rows", rows.max},
      {"rows_median", rows.p50},
      {"sweeps", sweeps.max},
      {"sweeps_median", sweeps.p50},
      {"ticks", m.ticks},
      {"ticks_counted", m.times.whole.wall.size()},
      {"state_hash", state_hash(simulation)},
      {"allocations", m.allocations},
      {"calibration_ms", 1e3 * median(m.solves.wall)},
      {"calibration_processor_ms", 1e3 * median(m.solves.processor)},
      {"tick", distribution(m.times.whole.wall)},
      {"tick_processor", distribution(m.times.whole.processor)},
      {"stages", stages(m.times)},
      {"compliance_and_solve", distribution(m.times.laws)},
      {"calibration", calibration_json(m, calibration)},
      {"ratios", ratios_json(m)},
      {"residual_max", m.residual_max},
      {"imbalance_max", m.imbalance_max},
      {"imbalance_share", m.imbalance_share},
      {"flags", flags_json(m.flags)},
      {"core", run.core},
      {"processor", processor_name()},
      {"kernels", name_of(kernel_set())},
      {"load_s", run.load_seconds},
      {"peak_memory_mib", run.peak_memory / (1 << 20)},
      {"each_tick", each_tick(m)},
  };
  // File names may hold any bytes.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace acus
