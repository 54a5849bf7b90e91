// SPDX-License-Identifier: MIT
// The folder that a scene lies in: what else there is to choose from, and recorded motions to play.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace acus::view {

struct SceneFolder {
  std::filesystem::path path;        // empty: none
  std::vector<std::string> scenes;   // names of path/NAME.yaml, in order
  std::vector<std::string> motions;  // names of path/trajectories/NAME.csv, in order

  std::filesystem::path motion(const std::string& name) const { return path / "trajectories" / (name + ".csv"); }
};

// Of `scene` as it is given to acus-server: a file, or the name of an installed scene.
SceneFolder look_around(const std::string& scene);

// The motion that is made for a scene: of its name, or the longest one that the scene's begins with; empty: none is.
std::string motion_for(const SceneFolder& folder, const std::string& scene);

}  // namespace acus::view
