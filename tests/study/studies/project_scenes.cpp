// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/project_scenes.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace acus {

std::string trajectory_of(const std::string& folder, const std::string& scene) {
  return folder + "/trajectories/" + scene + ".csv";
}

std::vector<std::string> scenes_with_motion(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".yaml" && std::filesystem::exists(trajectory_of(folder, entry.path().stem())))
      names.push_back(entry.path().stem());
  std::ranges::sort(names);
  if (names.empty()) throw std::runtime_error(folder + " has no scene with a trajectory; see --scenes");
  return names;
}

}  // namespace acus
