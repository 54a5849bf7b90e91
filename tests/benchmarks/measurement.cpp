// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/bench/measurement.h"

#include <doctest/doctest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "tests/study/bench/bench_report.h"
#include "tests/benchmarks/small_scene.h"

namespace acus {
namespace {

using Plan = MeasurementPlan;

// A run of the small scene.
struct Bench {
  Simulation simulation{test::small_scene()};
  TrajectoryDriver driver{simulation, test::small_push()};
  Calibration calibration{simulation};

  Measurement run(const Plan& plan) {
    return measure(simulation, driver, calibration, plan, [](std::uint64_t, std::uint64_t) {});
  }
};

TEST_CASE("all ticks are run, and those after the calibration do not count for times") {
  Bench bench;
  const Measurement m = bench.run({});
  CHECK(m.ticks == 126);
  CHECK(m.times.whole.wall.size() == 126 - Plan::kUncountedTicks);
  CHECK(m.times.stages[9].size() == m.times.whole.wall.size());
  CHECK(m.rows.size() == m.times.whole.wall.size());
  CHECK(m.solves.wall.size() == Plan::kSolvesPerBlock - Plan::kUncountedSolves);
  CHECK(m.dense_factorisations.processor.size() == m.solves.wall.size());
}

TEST_CASE("repeats begin anew; a skipped start and ticks with few rows do not count") {
  Bench bench;
  const Measurement all = bench.run({.repeat = 3});
  CHECK(all.ticks == 3 * 126);
  CHECK(all.times.whole.wall.size() == 3 * (126 - Plan::kUncountedTicks));
  const Measurement late = bench.run({.skip = 0.05});
  CHECK(late.times.whole.wall.size() == 76);
  const Measurement inside = bench.run({.min_rows = 4});
  CHECK(inside.times.whole.wall.size() > 0);
  CHECK(inside.times.whole.wall.size() < 110);
  const Measurement begun = bench.run({.max_ticks = 20});
  CHECK(begun.ticks == 20);
}

TEST_CASE("the stages of a tick add up to no more than the tick") {
  Bench bench;
  const Measurement m = bench.run({});
  for (std::size_t i = 0; i < m.times.whole.wall.size(); ++i) {
    double sum = 0;
    for (const std::vector<double>& stage : m.times.stages) sum += stage[i];
    CHECK(sum > 0);
    CHECK(sum <= m.times.whole.wall[i]);
    CHECK(m.times.whole.processor[i] > 0);
    CHECK(m.times.laws[i] == doctest::Approx(m.times.stages[5][i] + m.times.stages[6][i]));
  }
}

TEST_CASE("a report of nothing counted is still valid JSON") {
  Bench bench;
  BenchRun run;
  run.measured = bench.run({.min_rows = 1000});
  REQUIRE(run.measured.times.whole.wall.empty());
  const std::string json = bench_json(run, bench.simulation, bench.calibration);
  CHECK(json.find("nan") == std::string::npos);
  for (const char* member : {"tick_p99_to_p50", "p50_ms", "max_ms", "rows", "sweeps_median"})
    CHECK(json.find('"' + std::string(member) + "\": null") != std::string::npos);
  CHECK(bench_table(run, bench.simulation, bench.calibration).find("of which 0 count") != std::string::npos);
}

TEST_CASE("flags are told by name, with how often they were raised") {
  Bench bench;
  BenchRun run;
  run.measured.flags[0] = 3;
  run.measured.flags[9] = 1;
  CHECK(bench_table(run, bench.simulation, bench.calibration)
            .find("laws_not_converged in 3 ticks, publishing_reduced in 1 ticks") != std::string::npos);
}

TEST_CASE("results are JSON whatever bytes the names of files hold, and without a number where there is none") {
  Bench bench;
  BenchRun run;
  run.scene_file = "a\x01\t\n\"\\\x7f";
  run.trajectory_file = "\xff\xc3\u00e9.csv";
  run.measured = bench.run({});
  run.load_seconds = std::numeric_limits<double>::infinity();
  const nlohmann::json json = nlohmann::json::parse(bench_json(run, bench.simulation, bench.calibration));
  CHECK(json["scene"] == run.scene_file);
  CHECK(json["trajectory"] == "\ufffd\ufffd\u00e9.csv");
  CHECK(json["load_s"].is_null());
  CHECK(json["ticks"] == 126);
}

}  // namespace
}  // namespace acus
