// SPDX-License-Identifier: GPL-3.0-or-later
// Steps a scene without a server: pushes its first needle ahead along its axis at 10 mm/s for eight seconds of
// simulation time, as fast as it goes, and prints time (s), depth (mm) and force (N) ten times a second.
#include <cstdio>

#include "server/engine/scene/scene.h"
#include "server/engine/tick/simulation.h"

int main(int argc, char** argv) try {
  if (argc != 2) return std::fprintf(stderr, "usage: push SCENE.yaml\n"), 1;
  acus::Simulation simulation(acus::read_scene(argv[1]));
  const double rate = simulation.scene().rate;
  acus::Command command{.seq = 1, .pose = simulation.motion(0).pose, .spin = {}};
  const acus::Vector3 way = command.pose->orientation * acus::Vector3(0.01 / rate, 0, 0);
  for (int tick = 1; tick <= 8 * rate; ++tick, ++command.seq) {
    command.pose->position += way;
    simulation.command(0, command);
    simulation.step();
    const acus::NeedleReport& needle = simulation.report().needles[0];
    if (tick % static_cast<int>(rate / 10) == 0)
      std::printf("%.1f %.2f %.3f\n", tick / rate, 1e3 * needle.inserted_depth, needle.base_force.norm());
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "push: %s\n", error.what());
  return 2;
}
