// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/scene/files/scene_folders.h"

#include <algorithm>

#include "server/engine/scene/files/scene_error.h"

namespace acus {

namespace {

// An empty path if there is no telling, as where links run in a circle.
std::filesystem::path canonical(const std::filesystem::path& path) {
  std::error_code error;
  const auto found = std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
  return error ? std::filesystem::path() : found;
}

bool is_below(const std::filesystem::path& file, const std::filesystem::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

}  // namespace

SceneFolders::SceneFolders(const std::vector<std::string>& folders) {
  for (const std::string& folder : folders) {
    folders_.push_back(canonical(folder.empty() ? "." : folder));
    if (folders_.back().empty()) throw SceneError("folder \"" + folder + "\": expected one that can be found");
  }
}

std::string SceneFolders::find(const std::string& scene) const {
  std::error_code ignored;
  if (std::filesystem::exists(scene, ignored)) return scene;
  for (const auto& folder : folders_) {
    for (const auto& file : {folder / scene, folder / (scene + ".yaml")})
      if (contain(file) && std::filesystem::is_regular_file(file, ignored)) return file.string();
  }
  return scene;
}

bool SceneFolders::contain(const std::string& file) const { return contain_place(canonical(file)); }

void SceneFolders::check(const std::string& file, const std::string& what) const {
  if (!contain(file)) refuse(file, what);
}

void SceneFolders::check_opened(const std::string& link, const std::string& file, const std::string& what) const {
  std::error_code error;
  const auto place = std::filesystem::read_symlink(link, error);
  if (error) throw SceneError(what + " \"" + file + "\": where it is cannot be told: " + link + ": " + error.message());
  if (!contain_place(place)) refuse(file, what);
}

bool SceneFolders::contain_place(const std::filesystem::path& place) const {
  return !place.empty() &&
         std::any_of(folders_.begin(), folders_.end(), [&](const auto& folder) { return is_below(place, folder); });
}

void SceneFolders::refuse(const std::string& file, const std::string& what) const {
  std::string listed;
  for (const auto& folder : folders_) listed += (listed.empty() ? "\"" : ", \"") + folder.string() + "\"";
  throw SceneError(what + " \"" + file + "\": expected a file in the folders that clients may load from (" + listed +
                   "); acus-server --scenes FOLDER adds another one");
}

}  // namespace acus
