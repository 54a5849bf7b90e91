// SPDX-License-Identifier: MIT
#include "client/view/scene_folder.h"

#include <algorithm>
#include <system_error>

namespace acus::view {

namespace {

std::vector<std::string> names_in(const std::filesystem::path& folder, const std::string& extension) {
  std::vector<std::string> names;
  std::error_code error;
  for (std::filesystem::directory_iterator each(folder, error), end; !error && each != end; each.increment(error))
    if (each->path().extension() == extension && each->is_regular_file(error))
      names.push_back(each->path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

SceneFolder look_around(const std::string& scene) {
  std::error_code error;
  SceneFolder folder;
  if (std::filesystem::exists(scene, error) && !std::filesystem::is_directory(scene, error)) {
    folder.path = std::filesystem::absolute(scene, error).parent_path();
  } else {
    const auto programs = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
    for (const auto& installed : {std::filesystem::path("/etc/acus"), programs.parent_path() / "share/acus/scenes"})
      if (folder.path.empty() && std::filesystem::exists(installed / (scene + ".yaml"), error)) folder.path = installed;
  }
  if (folder.path.empty()) return folder;
  folder.scenes = names_in(folder.path, ".yaml");
  folder.motions = names_in(folder.path / "trajectories", ".csv");
  return folder;
}

std::string motion_for(const SceneFolder& folder, const std::string& scene) {
  std::string best;
  for (const std::string& motion : folder.motions)
    if (scene.starts_with(motion) && motion.size() > best.size()) best = motion;
  return best;
}

}  // namespace acus::view
