// SPDX-License-Identifier: GPL-3.0-or-later
// What a deferred field costs and saves (tissue.window): every scene along its own motion, as both are shipped but at
// 1 kHz and on rung `warped`, against the same without.
#include <algorithm>
#include <limits>
#include <span>
#include <stdexcept>

#include "client/replay/trajectory.h"
#include "server/engine/math/nearest_rank.h"
#include "server/engine/math/processor_time.h"
#include "tests/study/bench/trajectory_driver.h"
#include "tests/study/studies/csv.h"
#include "tests/study/studies/project_scenes.h"
#include "tests/study/studies/study.h"

namespace acus {

namespace {

constexpr double kRate = 1000;  // Hz
constexpr int kWindows[] = {0, 4, 8, 16, 32, 64};
constexpr int kQuickWindows[] = {0, 16};
constexpr std::size_t kQuickScenes = 2;
constexpr std::uint64_t kQuickTicks = 2000;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  // does not apply

struct Track {
  int nodes = 0;
  std::vector<Vector3> base_force, tip;  // N, m: all needles of a tick, then those of the next
  std::vector<double> tick_seconds;      // processor time
  int held_back = 0, unbalanced = 0;     // ticks with that flag
};

struct WindowRun {
  std::string scene, refused;
  int nodes = 0, window = 0;
  double force_p50 = kNone, force_p95 = kNone, force_p99 = kNone, force_max = kNone, largest_force = kNone;  // N
  double tip_p95 = kNone;                                                                                    // m
  double run_time = kNone, tick_p50 = kNone, tick_p99 = kNone;
  double held_back = kNone, unbalanced = kNone;
};

constexpr Column<WindowRun> kColumns[] = {
    {"scene", [](const WindowRun& r) { return Cell(r.scene); }},
    {"nodes", [](const WindowRun& r) { return Cell(r.nodes); }},
    {"window", [](const WindowRun& r) { return Cell(r.window); }},
    {"force_p50", [](const WindowRun& r) { return Cell(r.force_p50); }},  // N, of differences
    {"force_p95", [](const WindowRun& r) { return Cell(r.force_p95); }},
    {"force_p99", [](const WindowRun& r) { return Cell(r.force_p99); }},
    {"force_max", [](const WindowRun& r) { return Cell(r.force_max); }},
    {"force_size", [](const WindowRun& r) { return Cell(r.largest_force); }},  // N, the largest there is
    {"tip_p95", [](const WindowRun& r) { return Cell(r.tip_p95); }},           // m
    {"run_time", [](const WindowRun& r) { return Cell(r.run_time); }},         // s per simulated s
    {"ms_p50", [](const WindowRun& r) { return Cell(r.tick_p50); }},
    {"ms_p99", [](const WindowRun& r) { return Cell(r.tick_p99); }},
    {"held_back", [](const WindowRun& r) { return Cell(r.held_back); }},    // share of ticks
    {"unbalanced", [](const WindowRun& r) { return Cell(r.unbalanced); }},  // likewise
    {"refused", [](const WindowRun& r) { return Cell(r.refused); }},
};

Track follow(const Scene& scene, const client::Trajectory& motion, std::uint64_t most_ticks) {
  Simulation simulation(scene);
  TrajectoryDriver driver(simulation, motion);
  Track track;
  track.nodes = simulation.mesh().node_count();
  for (std::uint64_t tick = 0; tick < std::min(driver.ticks(), most_ticks); ++tick) {
    driver.command();
    track.tick_seconds.push_back(processor_time_of([&] { simulation.step(); }));
    for (const NeedleReport& needle : simulation.report().needles) {
      track.base_force.push_back(needle.base_force);
      track.tip.push_back(needle.tip_position);
    }
    track.held_back += (simulation.report().flags & kStepLimited) != 0;
    track.unbalanced += (simulation.report().flags & kForcesUnbalanced) != 0;
  }
  return track;
}

std::vector<double> distances(const std::vector<Vector3>& a, const std::vector<Vector3>& b) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < a.size(); ++i) lengths.push_back((a[i] - b[i]).norm());
  return lengths;
}

void compare(Track& track, const Track& reference, WindowRun& row) {
  std::vector<double> force = distances(track.base_force, reference.base_force),
                      tip = distances(track.tip, reference.tip);
  row.nodes = track.nodes;
  row.force_p50 = nearest_rank(force, 0.5);
  row.force_p95 = nearest_rank(force, 0.95);
  row.force_p99 = nearest_rank(force, 0.99);
  row.force_max = nearest_rank(force, 1);
  row.tip_p95 = nearest_rank(tip, 0.95);
  row.largest_force = 0;
  for (const Vector3& f : reference.base_force) row.largest_force = std::max(row.largest_force, f.norm());
  const auto ticks = static_cast<double>(track.tick_seconds.size());
  double sum = 0;
  for (const double seconds : track.tick_seconds) sum += seconds;
  row.run_time = sum * kRate / ticks;
  row.tick_p50 = 1e3 * nearest_rank(track.tick_seconds, 0.5);
  row.tick_p99 = 1e3 * nearest_rank(track.tick_seconds, 0.99);
  row.held_back = track.held_back / ticks;
  row.unbalanced = track.unbalanced / ticks;
}

}  // namespace

void study_windows(const StudyPlan& plan) {
  CsvFile file(plan.out + "/windows.csv", names_of(kColumns));
  std::vector<std::string> names = scenes_with_motion(plan.scenes);
  if (plan.quick && names.size() > kQuickScenes) names.resize(kQuickScenes);
  const std::span<const int> windows = plan.quick ? std::span<const int>(kQuickWindows) : kWindows;
  const std::uint64_t most_ticks = plan.quick ? kQuickTicks : std::numeric_limits<std::uint64_t>::max();
  const auto runs = static_cast<int>(names.size() * windows.size());
  int done = 0;
  for (const std::string& name : names) {
    Scene scene = read_scene(plan.scenes + "/" + name + ".yaml");
    scene.rate = kRate;
    scene.tissue.rung = TissueRung::warped;
    const client::Trajectory motion = client::read_trajectory(trajectory_of(plan.scenes, name));
    Track reference;
    for (const int window : windows) {
      plan.progress(done++, runs, name + ", window " + std::to_string(window));
      WindowRun row;
      row.scene = name;
      row.window = window;
      scene.tissue.window = window;
      try {
        validate(scene);
        Track track = follow(scene, motion, most_ticks);
        if (window == 0) reference = track;
        compare(track, reference, row);
      } catch (const std::runtime_error& error) {
        row.refused = error.what();
      }
      file.row(cells_of(kColumns, row));
    }
  }
  plan.progress(runs, runs, "done");
}

}  // namespace acus
