// SPDX-License-Identifier: GPL-3.0-or-later
// The scenes of scenes/ that have a trajectory, for tests that run each of them.
#pragma once

#include <string>

#include "client/replay/trajectory.h"
#include "server/engine/scene/scene.h"
#include "tests/support/places.h"

namespace acus::test {

struct SceneWithTrajectory {
  const char* scene;
  const char* trajectory;
  bool relaxes = false;  // its tissue does: not on every rung

  bool runs_on(TissueRung rung) const { return !relaxes || rung == TissueRung::warped || rung == TissueRung::refined; }
};
inline constexpr SceneWithTrajectory kScenes[] = {
    {"biopsy", "biopsy"},
    {"bone", "bone"},
    {"brachytherapy", "brachytherapy"},
    {"crossing", "crossing"},
    {"deep_brain", "deep_brain"},
    {"inclusion_soft_needle", "inclusion_soft_needle"},
    {"inclusion_stiff_needle", "inclusion_stiff_needle"},
    {"inclusion_supported", "inclusion_supported"},
    {"insertion_pullback", "insertion_pullback"},
    {"insertion_pullback_layers", "insertion_pullback"},
    {"layers", "layers"},
    {"liver_insertion", "liver_insertion"},
    {"liver_relaxation", "liver_relaxation", true},
    {"steering", "steering"},
    {"steering_arc", "steering_arc"},
    {"through", "through"},
};

inline std::string scene_file(const std::string& scene) { return source_path("scenes/") + scene + ".yaml"; }

// The motion of scenes/trajectories/, `speed_up` times as fast: all that happens in it, in fewer ticks.
inline client::Trajectory fast_trajectory(const std::string& name, double speed_up) {
  client::Trajectory trajectory = client::read_trajectory(source_path("scenes/trajectories/") + name + ".csv");
  for (client::Motion& motion : trajectory.motions)
    for (client::Sample& sample : motion.samples) sample.time /= speed_up;
  return trajectory;
}

}  // namespace acus::test
