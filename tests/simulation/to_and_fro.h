// SPDX-License-Identifier: GPL-3.0-or-later
// The scenes and the ways to solve them on which ticks are watched for what they must not do, and the motion.
#pragma once

#include <array>
#include <functional>
#include <string>

#include "server/simulation/simulation.h"

namespace acus::test {

// A scene of scenes/ by its name, and how deep its first needle goes (m).
struct WatchedScene {
  const char* name;
  double depth;
};

inline constexpr std::array kWatchedScenes{
    WatchedScene{"insertion_pullback", 0.05},     // puncture, cutting, friction, withdrawal
    WatchedScene{"steering", 0.06},               // a bevel in its guide, torsional friction
    WatchedScene{"inclusion_soft_needle", 0.06},  // contact with an inclusion, and along it
    WatchedScene{"through", 0.06},                // out on the other side and back
};

// Ways to solve a scene. Rung `exact` factorises in every tick, where CHOLMOD asks for memory.
struct WatchedWay {
  TissueRung rung;
  LawMethod solver;
};

inline constexpr std::array kWatchedWays{
    WatchedWay{TissueRung::none, LawMethod::direct}, WatchedWay{TissueRung::linear, LawMethod::direct},
    WatchedWay{TissueRung::warped, LawMethod::gauss_seidel}, WatchedWay{TissueRung::warped, LawMethod::direct},
    WatchedWay{TissueRung::refined, LawMethod::gauss_seidel}};

inline Scene load_watched(const WatchedScene& watched, const WatchedWay& way) {
  Scene scene = read_scene(std::string(ACUS_SOURCE_DIR) + "/scenes/" + watched.name + ".yaml");
  scene.tissue.rung = way.rung;
  scene.laws.solver = way.solver;
  return scene;
}

// The base of the first needle goes `depth` (m) along its axis and back at 40 mm/s, spinning; `step` makes each tick.
inline void to_and_fro(Simulation& simulation, double depth, const std::function<void()>& step) {
  const Pose base = simulation.scene().needles[0].base;
  const Vector3 axis = base.orientation * Vector3::UnitX();
  const double advance = 0.04 / simulation.scene().rate;
  const int ticks = static_cast<int>(depth / advance);
  for (int tick = 0; tick < 2 * ticks; ++tick) {
    const double at = advance * (tick < ticks ? tick : 2 * ticks - tick);
    simulation.command(0, {1, Pose{base.position + at * axis, base.orientation}, 1e-3 * tick});
    step();
  }
}

}  // namespace acus::test
