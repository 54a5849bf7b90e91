// SPDX-License-Identifier: GPL-3.0-or-later
// The scenes and the ways to solve them on which ticks are watched for what they must not do, and the motion.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "server/engine/tick/simulation.h"
#include "tests/support/places.h"

namespace acus::test {

// A scene of scenes/ by its name, how deep its needles go (m), and what is changed in it.
struct ScannedScene {
  const char* name;
  double depth;
  bool rigid = false;          // all needles
  bool second_needle = false;  // 15 mm beside the first
  TissueElement element = TissueElement::linear;
  LocalCompliance give = LocalCompliance::all;
  bool held = false;     // all bases, by springs
  bool relaxes = false;  // where the rung can: all tissue, and friction that thins and is another on the way back
};

inline constexpr std::array kWatchedScenes{
    ScannedScene{"insertion_pullback", 0.05},     // puncture, cutting, friction, withdrawal
    ScannedScene{"steering", 0.06},               // a bevel in its guide, torsional friction
    ScannedScene{"inclusion_soft_needle", 0.06},  // contact with an inclusion, and along it
    ScannedScene{"through", 0.06},                // out on the other side and back
    ScannedScene{.name = "insertion_pullback", .depth = 0.02, .rigid = true},
    ScannedScene{.name = "insertion_pullback", .depth = 0.02, .second_needle = true},
    ScannedScene{.name = "insertion_pullback", .depth = 0.02, .held = true},
    ScannedScene{.name = "insertion_pullback", .depth = 0.02, .rigid = true, .held = true},
    ScannedScene{.name = "inclusion_soft_needle", .depth = 0.012, .element = TissueElement::nodal_pressure},
    ScannedScene{.name = "inclusion_soft_needle", .depth = 0.06, .give = LocalCompliance::none},
    ScannedScene{.name = "through", .depth = 0.06, .relaxes = true},
};

// Ways to solve a scene. Rung `exact` factorises in every tick, where CHOLMOD asks for memory.
struct WatchedWay {
  TissueRung rung;
  LawMethod solver;
  bool economical = false;  // Simulation::economize()
  int window = 0;
};

inline constexpr std::array kWatchedWays{
    WatchedWay{TissueRung::none, LawMethod::direct},
    WatchedWay{TissueRung::linear, LawMethod::direct},
    WatchedWay{TissueRung::linear, LawMethod::gauss_seidel},
    WatchedWay{TissueRung::warped, LawMethod::direct},
    WatchedWay{TissueRung::warped, LawMethod::gauss_seidel},
    WatchedWay{TissueRung::refined, LawMethod::direct},
    WatchedWay{TissueRung::refined, LawMethod::gauss_seidel},
    WatchedWay{TissueRung::refined, LawMethod::direct, true},
    WatchedWay{TissueRung::warped, LawMethod::gauss_seidel, true},
    WatchedWay{.rung = TissueRung::warped, .solver = LawMethod::direct, .window = 6}};

inline void add_second_needle(Scene& scene) {
  Needle second = scene.needles[0];
  second.name = "second";
  second.base.position += Vector3(0.015, 0, 0);
  scene.needles.push_back(second);
}

inline void let_relax(Scene& scene) {
  if (scene.tissue.rung != TissueRung::warped && scene.tissue.rung != TissueRung::refined) return;
  scene.tissue.window = 0;
  for (Region& region : scene.tissue.regions) {
    region.material.relaxation = {{.ratio = 0.6, .time = 0.05}, {.ratio = 0.4, .time = 1}};
    region.interaction.friction_thinning_speed = 5e-3;
    region.interaction.friction_exponent = 0.3;
    region.interaction.friction_back = 0.5;
  }
}

inline Scene load_watched(const ScannedScene& watched, const WatchedWay& way) {
  Scene scene = read_scene(source_path("scenes/") + watched.name + ".yaml");
  scene.tissue.rung = way.rung;
  scene.tissue.local_compliance = watched.give;
  scene.tissue.element = watched.element;
  scene.laws.solver = way.solver;
  if (scene.tissue.element == TissueElement::linear) scene.tissue.window = way.window;
  if (watched.rigid) scene.needles[0].rung = NeedleRung::rigid;
  if (watched.held) scene.needles[0].hold = BaseHold{};
  if (watched.second_needle) add_second_needle(scene);
  if (watched.relaxes) let_relax(scene);
  return scene;
}

// Loads the scene once for each way to solve it, the way captured, and calls watch(simulation).
template <class Watch>
void for_each_way(const ScannedScene& watched, Watch watch) {
  for (const WatchedWay& way : kWatchedWays) {
    CAPTURE(static_cast<int>(way.rung));
    CAPTURE(static_cast<int>(way.solver));
    CAPTURE(way.economical);
    CAPTURE(way.window);
    Simulation simulation(load_watched(watched, way));
    simulation.economize(way.economical);
    watch(simulation);
  }
}

// The bases of all needles go `depth` (m) along their axes and back at 100 mm/s, spinning; `step` makes each tick.
inline void to_and_fro(Simulation& simulation, double depth, const std::function<void()>& step) {
  const std::vector<Needle>& needles = simulation.scene().needles;
  const double advance = 0.1 / simulation.scene().rate;
  const int ticks = static_cast<int>(depth / advance);
  for (int tick = 0; tick < 2 * ticks; ++tick) {
    const double at = advance * (tick < ticks ? tick : 2 * ticks - tick);
    for (std::size_t i = 0; i < needles.size(); ++i) {
      const Pose& base = needles[i].base;
      const Vector3 axis = base.orientation * Vector3::UnitX();
      simulation.command(static_cast<int>(i), {1, Pose{base.position + at * axis, base.orientation}, 1e-3 * tick});
    }
    step();
  }
}

}  // namespace acus::test
