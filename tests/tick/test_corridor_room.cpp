// SPDX-License-Identifier: GPL-3.0-or-later
// A corridor with room for fewer nodes than a needle touches, which no mesh of fair shape brings about.
#include <doctest/doctest.h>

#include "server/engine/tick/step.h"
#include "tests/tick/bench.h"

namespace acus::test {

TEST_CASE("rows whose nodes have no room bear no force, raise a flag and cut nothing; all else goes on") {
  Scene scene = block_scene();
  Needle& needle = scene.needles[0];
  needle.torsional_friction = 1;
  scene.tissue.regions[0].interaction.puncture_force = 0.3;
  scene.tissue.regions[0].interaction.cutting_force = 0.2;
  const Model model(scene);
  Scratch scratch(model);
  State state = make_state(model);
  TickReport report;
  report.needles.resize(scene.needles.size());
  report.events.reserve(scratch.events.capacity());
  Commands commands(scene.needles.size());
  const Vector3 along = needle.base.orientation * Vector3::UnitX();
  const auto advance = [&](double by) {
    Command command{.seq = state.tick + 1, .pose = state.bases[0].target, .spin = {}};
    command.pose->position += by * along;
    commands[0] = command;
    step(model, commands, state, scratch, report);
  };
  for (int i = 0; i < 2000 && report.needles[0].inserted_depth < 0.02; ++i) advance(2e-5);
  REQUIRE(report.needles[0].inserted_depth >= 0.02);
  CHECK((report.flags & kRowsDropped) == 0);
  const double held = report.needles[0].lateral_force.norm() + report.needles[0].friction_force.norm();
  CHECK(held > 0.01);

  constexpr int kNodes = 6;
  scratch.tissue.rows.emplace(model.tissue_system.factor, model.max_rows, kNodes);
  const std::size_t vertices = state.paths[0].vertices.size();
  for (int i = 0; i < 50; ++i) {
    advance(2e-5);
    CHECK((report.flags & kRowsDropped) != 0);
    CHECK((report.flags & (kNotFinite | kLawsNotConverged)) == 0);
    CHECK(report.needles[0].friction_force.norm() < held);
  }
  CHECK(state.paths[0].vertices.size() <= vertices + 1);
}

}  // namespace acus::test
