// SPDX-License-Identifier: GPL-3.0-or-later
// Whole insertions with a base on springs: what the holder feels, where the base is, and a state that goes on.
#include <doctest/doctest.h>

#include "server/engine/state/bytes/state_bytes.h"
#include "server/engine/tick/simulation.h"
#include "tests/support/small_block.h"

namespace acus {
namespace {

Scene held_scene(const std::optional<BaseHold>& hold, NeedleRung rung = NeedleRung::flexible) {
  Scene scene = test::small_block();
  scene.needles[0].rung = rung;
  scene.needles[0].hold = hold;
  return scene;
}

void push(Simulation& simulation, Pose& commanded, double way) {
  commanded.position += commanded.orientation * Vector3(way, 0, 0);
  REQUIRE(simulation.command(0, {.seq = 1, .pose = commanded, .spin = {}}));
  simulation.step();
}

double axial(const NeedleReport& needle) { return -(needle.commanded.orientation.conjugate() * needle.base_force).x(); }

}  // namespace

TEST_CASE("inside and at rest a base stands behind where it is told by its force over the spring's stiffness") {
  for (const NeedleRung rung : {NeedleRung::flexible, NeedleRung::rigid}) {
    const BaseHold hold{.stiffness = 300, .damping = 1, .angular_stiffness = 3, .angular_damping = 0.01};
    Simulation simulation(held_scene(hold, rung));
    Pose commanded = simulation.scene().needles[0].base;
    for (int tick = 0; tick < 1200; ++tick) push(simulation, commanded, 2e-5);
    for (int tick = 0; tick < 3000; ++tick) push(simulation, commanded, 0);
    const NeedleReport& needle = simulation.report().needles[0];
    REQUIRE(needle.phase == Phase::inside);
    const Vector3 behind = needle.commanded.position - needle.base.position;
    CHECK((needle.base_force + hold.stiffness * behind).norm() < 1e-3 * needle.base_force.norm());
    CHECK(axial(needle) > 0.05);
    CHECK(simulation.report().imbalance < 1e-3 * simulation.report().largest_force);
  }
}

TEST_CASE("the softer the springs, the later the puncture, by the force that it takes over their stiffness") {
  const auto puncture_at = [](const std::optional<BaseHold>& hold) {
    Simulation simulation(held_scene(hold));
    Pose commanded = simulation.scene().needles[0].base;
    for (int tick = 0; tick < 4000; ++tick) {
      push(simulation, commanded, 1e-5);
      for (const Event& event : simulation.report().events)
        if (event.kind == EventKind::puncture)
          return std::pair((commanded.position - simulation.scene().needles[0].base.position).norm(), event.force);
    }
    FAIL("it does not puncture");
    return std::pair(0.0, 0.0);
  };
  const auto [commanded, force] = puncture_at(std::nullopt);
  const auto [soft, soft_force] = puncture_at(BaseHold{.stiffness = 150, .damping = 1, .angular_stiffness = 100});
  const auto [stiff, stiff_force] = puncture_at(BaseHold{.stiffness = 1e8, .damping = 1, .angular_stiffness = 1e6});
  CHECK(soft_force == doctest::Approx(force).epsilon(0.02));
  CHECK(soft - commanded == doctest::Approx(force / 150).epsilon(0.05));
  CHECK(std::abs(stiff - commanded) < 2e-5);
}

TEST_CASE("a copied state of a needle on springs goes on as the original") {
  const Scene scene = held_scene(BaseHold{});
  Simulation one(scene), other(scene);
  Pose commanded = scene.needles[0].base;
  for (int tick = 0; tick < 900; ++tick) push(one, commanded, 3e-5);
  other.restore(one.state());
  Pose same = commanded;
  for (int tick = 0; tick < 200; ++tick) {
    push(one, commanded, 3e-5);
    push(other, same, 3e-5);
  }
  CHECK(to_bytes(one.state()) == to_bytes(other.state()));
}

}  // namespace acus
