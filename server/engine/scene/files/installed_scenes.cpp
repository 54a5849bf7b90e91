// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/scene/files/installed_scenes.h"

#include <system_error>

namespace acus {
namespace {

// A pipe is a file, too.
bool is_file(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored) && !std::filesystem::is_directory(path, ignored);
}

}  // namespace

std::vector<std::filesystem::path> installed_scene_folders() {
  std::vector<std::filesystem::path> folders{"/etc/acus"};
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) folders.push_back(self.parent_path().parent_path() / "share/acus/scenes");
  return folders;
}

std::string find_scene(const std::string& scene, const std::vector<std::filesystem::path>& folders) {
  if (is_file(scene) || scene.starts_with('/')) return scene;
  for (const std::filesystem::path& folder : folders) {
    const std::filesystem::path file = folder / (scene + ".yaml");
    if (is_file(file)) return file.string();
  }
  return scene;
}

}  // namespace acus
