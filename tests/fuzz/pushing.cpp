// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/pushing.h"

#include <algorithm>

#include "server/engine/state/bytes/state_check.h"
#include "tests/fuzz/fuzz.h"

namespace acus::fuzz {

void push(Simulation& simulation, double distance) {
  for (int needle = 0; needle < simulation.model().needle_count(); ++needle) {
    Pose pose = simulation.motion(needle).target;
    const double most = simulation.scene().needles[needle].max_speed * simulation.model().h;
    pose.position += std::min(distance, most) * (pose.orientation * Vector3::UnitX());
    simulation.command(needle, {.seq = simulation.state().tick + 1, .pose = pose, .spin = {}});
  }
  simulation.step();
}

void push_on(Simulation& simulation) {
  constexpr int kTicks = 30;
  for (int i = 0; i < kTicks; ++i) {
    push(simulation, 1e-3);
    check_state(simulation.model(), simulation.state());
    for (const NeedleReport& needle : simulation.report().needles)
      require(needle.tip_force.allFinite() && needle.base_force.allFinite() && needle.base_torque.allFinite(),
              "a force is a number");
  }
}

}  // namespace acus::fuzz
