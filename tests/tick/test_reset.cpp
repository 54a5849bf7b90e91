// SPDX-License-Identifier: GPL-3.0-or-later
// After a reset nothing is left of what went before: the same commands give the same numbers, bit for bit.
#include <doctest/doctest.h>

#include "tests/tick/bench.h"

namespace acus::test {
namespace {

// Every memory that a run can leave behind: a path that slides on bone, torsion, a guide with friction, a bevel.
Scene eventful_scene() {
  Scene scene = block_scene();
  Region bone = scene.tissue.regions[0];
  bone.name = "bone";
  bone.half_space = HalfSpace{Vector3(0, 0, 0.01), Vector3::UnitZ()};
  bone.interaction.puncture_force = kInfinity;
  scene.tissue.regions.push_back(bone);
  Needle& needle = scene.needles[0];
  needle.cutting_direction = {1, 0.2, 0};
  needle.torsional_friction = 1;
  Guide guide;
  guide.pose = {Vector3(0.003, 0.002, 0.034), needle.base.orientation};
  guide.friction = 0.2;
  scene.guides = {guide};
  return scene;
}

struct Record {
  std::vector<Vector3> forces, tips;
  std::vector<EventKind> events;
  bool operator==(const Record&) const = default;
};

Record run(Simulation& simulation) {
  Record record;
  const Pose base = simulation.scene().needles[0].base, hole = simulation.scene().guides[0].pose;
  for (int tick = 1; tick <= 900; ++tick) {
    const double depth = 4e-5 * std::min(tick, 780);
    simulation.command(0, {1, Pose{base.position - depth * Vector3::UnitZ(), base.orientation}, 2e-3 * tick});
    simulation.command(1, {1, Pose{hole.position + 1e-6 * tick * Vector3::UnitX(), hole.orientation}, std::nullopt});
    simulation.step();
    const TickReport& report = simulation.report();
    record.forces.push_back(report.needles[0].base_force);
    record.tips.push_back(report.needles[0].tip_position);
    for (const Event& event : report.events) record.events.push_back(event.kind);
  }
  return record;
}

TEST_CASE("a reset in the middle of contact with bone leaves nothing behind" * doctest::test_suite("gate")) {
  Simulation simulation(eventful_scene());
  const Record first = run(simulation);
  REQUIRE(first.events.size() >= 3);  // contact, puncture, contact with bone
  simulation.reset();
  CHECK(simulation.report().tick == 0);
  CHECK(run(simulation) == first);
}

// The base jumps aside while the needle is inside: steps are cut, and what guards them remembers it.
Record jump(Simulation& simulation, std::uint32_t& flags) {
  Record record;
  const Pose base = simulation.scene().needles[0].base;
  for (int tick = 1; tick <= 400; ++tick) {
    const Vector3 aside = tick > 350 ? Vector3(0.05, 0, 0) : Vector3(0, 0, 0);
    const double depth = 1e-4 * std::min(tick, 300);
    simulation.command(0, {1, Pose{base.position + aside - depth * Vector3::UnitZ(), base.orientation}, std::nullopt});
    simulation.step();
    flags |= simulation.report().flags;
    record.forces.push_back(simulation.report().needles[0].base_force);
    record.tips.push_back(simulation.report().needles[0].tip_position);
  }
  return record;
}

TEST_CASE("a reset after steps that were cut leaves nothing behind") {
  Scene scene = block_scene();
  scene.needles[0].max_speed = 100;
  scene.needles[0].smoothing = 0;
  Simulation simulation(scene);
  std::uint32_t flags = 0;
  const Record first = jump(simulation, flags);
  REQUIRE((flags & kStepLimited) != 0);
  simulation.reset();
  CHECK(jump(simulation, flags) == first);
}

}  // namespace
}  // namespace acus::test
