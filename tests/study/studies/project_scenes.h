// SPDX-License-Identifier: GPL-3.0-or-later
// The project's scenes that have a motion of their own.
#pragma once

#include <string>
#include <vector>

namespace acus {

// scenes/trajectories/SCENE.csv in that folder.
std::string trajectory_of(const std::string& scenes_folder, const std::string& scene);

// Scenes with such a trajectory, by name; throws std::runtime_error if there is none.
std::vector<std::string> scenes_with_motion(const std::string& scenes_folder);

}  // namespace acus
