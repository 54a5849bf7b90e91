// SPDX-License-Identifier: GPL-3.0-or-later
// Bases that stop at random moments: what moved against friction and viscosity settles, and nothing may jump.
#include <algorithm>

#include "client/replay/trajectory.h"
#include "server/engine/math/random.h"
#include "tests/study/bench/trajectory_driver.h"
#include "tests/study/studies/csv.h"
#include "tests/study/studies/force_jumps.h"
#include "tests/study/studies/project_scenes.h"
#include "tests/study/studies/study.h"

namespace acus {

namespace {

constexpr double kRate = 1000;  // Hz
constexpr double kHeld = 0.3;   // s
constexpr int kHolds = 1000, kQuickHolds = 20;
constexpr std::size_t kQuickScenes = 4;

struct Hold {
  std::string scene;
  double time = 0;  // s, when the bases stop
  int needle = 0;   // with the largest jump,
  ForceJump jump;   // ticks from the stop on
};

constexpr Column<Hold> kColumns[] = {
    {"scene", [](const Hold& hold) -> Cell { return hold.scene; }},
    {"time_s", [](const Hold& hold) -> Cell { return hold.time; }},
    {"needle", [](const Hold& hold) -> Cell { return hold.needle; }},
    {"jump_N", [](const Hold& hold) -> Cell { return hold.jump.size; }},
    {"after_s", [](const Hold& hold) -> Cell { return static_cast<double>(hold.jump.tick + 1) / kRate; }},
};

// Goes on from `held` with the bases at rest.
Hold hold(Simulation& held) {
  std::vector<TickReport> ticks;
  for (int i = 0; i < kHeld * kRate; ++i) {
    held.step();
    ticks.push_back(held.report());
  }
  Hold worst;
  for (int i = 0; i < static_cast<int>(held.scene().needles.size()); ++i) {
    const ForceJump jump = largest_unexplained(ticks, i);
    if (jump.size > worst.jump.size) worst.needle = i, worst.jump = jump;
  }
  return worst;
}

void hold_in_scene(const StudyPlan& plan, const std::string& name, int holds, unsigned seed, CsvFile& file) {
  Scene scene = read_scene(plan.scenes + "/" + name + ".yaml");
  scene.rate = kRate;
  Simulation moved(scene), held(scene);
  TrajectoryDriver driver(moved, client::read_trajectory(trajectory_of(plan.scenes, name)));
  Random random(seed);
  std::vector<std::uint64_t> stops;
  for (int i = 0; i < holds; ++i)
    stops.push_back(1 + static_cast<std::uint64_t>(random.uniform(0, 1) * static_cast<double>(driver.ticks() - 1)));
  std::ranges::sort(stops);
  std::uint64_t tick = 0;
  for (const std::uint64_t stop : stops) {
    for (; tick < stop; ++tick) {
      driver.command();
      moved.step();
    }
    held.restore(moved.state());
    Hold outcome = hold(held);
    outcome.scene = name;
    outcome.time = static_cast<double>(stop) / kRate;
    file.row(cells_of(kColumns, outcome));
  }
}

}  // namespace

void study_holds(const StudyPlan& plan) {
  CsvFile file(plan.out + "/holds.csv", names_of(kColumns));
  std::vector<std::string> names = scenes_with_motion(plan.scenes);
  if (plan.quick && names.size() > kQuickScenes) names.resize(kQuickScenes);
  const auto count = static_cast<int>(names.size());
  const int holds = ((plan.quick ? kQuickHolds : kHolds) + count - 1) / count;
  for (int i = 0; i < count; ++i) {
    plan.progress(i * holds, count * holds, names[i]);
    hold_in_scene(plan, names[i], holds, static_cast<unsigned>(i) + 1, file);
  }
  plan.progress(count * holds, count * holds, "done");
}

}  // namespace acus
