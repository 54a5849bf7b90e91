// SPDX-License-Identifier: GPL-3.0-or-later
// test_golden: runs the scenes of scenes/ in every rung that serves in real time and with both solvers of the laws, and
// compares a hash of each run with a table, or rewrites the table.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "tests/study/bench/trajectory_driver.h"
#include "tests/golden/golden_table.h"
#include "tests/golden/trace_hash.h"
#include "tests/support/scenes.h"

namespace acus::test {
namespace {

constexpr const char* kUsage =
    "usage: test_golden TABLE [SCENE RUNG]   run, compare with the table, exit 1 where a hash differs\n"
    "       test_golden TABLE --update [SCENE RUNG]   run and rewrite the table\n";

constexpr double kSpeedUp = 4;  // of the trajectories

struct Rung {
  const char* name;
  TissueRung rung;
};
constexpr Rung kRungs[] = {
    {"linear", TissueRung::linear}, {"warped", TissueRung::warped}, {"refined", TissueRung::refined}};

struct Solver {
  const char* name;
  LawMethod method;
};
constexpr Solver kSolvers[] = {{"direct", LawMethod::direct}, {"gauss_seidel", LawMethod::gauss_seidel}};

GoldenRow run(const SceneWithTrajectory& experiment, const Rung& rung, const Solver& solver) {
  Scene scene = read_scene(scene_file(experiment.scene));
  scene.tissue.rung = rung.rung;
  scene.laws.solver = solver.method;
  Simulation simulation(scene);
  TrajectoryDriver driver(simulation, fast_trajectory(experiment.trajectory, kSpeedUp));
  TraceHash hash;
  const std::uint64_t ticks = driver.ticks();
  for (std::uint64_t i = 0; i < ticks; ++i) {
    driver.command();
    simulation.step();
    hash.add(simulation);
  }
  return {experiment.scene, rung.name, solver.name, ticks, hash.value()};
}

// Those of a scene and a rung, or all where these are empty.
std::vector<GoldenRow> run_all(const std::string& scene, const std::string& rung) {
  std::vector<GoldenRow> rows;
  for (const SceneWithTrajectory& experiment : kScenes)
    for (const Rung& r : kRungs)
      for (const Solver& solver : kSolvers) {
        if (!experiment.runs_on(r.rung)) continue;
        if (!scene.empty() && (scene != experiment.scene || rung != r.name)) continue;
        rows.push_back(run(experiment, r, solver));
        std::printf("%s\n", rows.back().text().c_str());
        std::fflush(stdout);
      }
  return rows;
}

// How many rows the table does not have as they are.
int compare(const GoldenTable& table, const std::vector<GoldenRow>& rows) {
  int differing = 0;
  for (const GoldenRow& row : rows) {
    const GoldenRow* known = table.find(row);
    if (known && known->hash == row.hash && known->ticks == row.ticks) continue;
    ++differing;
    std::printf("differs: %s\n  table: %s\n", row.text().c_str(), known ? known->text().c_str() : "no such row");
  }
  if (differing > 0)
    std::printf("%d of %zu hashes differ. If the change is meant to change what is computed, run scripts/golden --update "
                "and say in the commit which rows changed and why.\n", differing, rows.size());
  return differing;
}

int golden_main(std::vector<std::string> arguments) {
  if (arguments.empty()) return std::fputs(kUsage, stderr), 2;
  const std::string table_file = arguments[0];
  const bool update = arguments.size() > 1 && arguments[1] == "--update";
  arguments.erase(arguments.begin(), arguments.begin() + (update ? 2 : 1));
  if (!arguments.empty() && arguments.size() != 2) return std::fputs(kUsage, stderr), 2;
  const std::string scene = arguments.empty() ? "" : arguments[0], rung = arguments.empty() ? "" : arguments[1];

  GoldenTable table = GoldenTable::read(table_file);
  const std::vector<GoldenRow> rows = run_all(scene, rung);
  if (rows.empty()) return std::fprintf(stderr, "test_golden: no scene %s in rung %s\n", scene.c_str(), rung.c_str()), 2;
  if (!update) return compare(table, rows) == 0 ? 0 : 1;
  for (const GoldenRow& row : rows) table.put(row);
  table.write(table_file);
  return 0;
}

}  // namespace
}  // namespace acus::test

int main(int argc, char** argv) {
  try {
    return acus::test::golden_main({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "test_golden: %s\n", error.what());
    return 2;
  }
}
