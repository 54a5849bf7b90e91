// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/scene/field_error.h"

namespace acus {
namespace {

// "tissue.regions[0].box" -> "tissue.regions[0]" -> "tissue.regions" -> "tissue" -> "".
std::string parent_path(const std::string& path) {
  const std::size_t end = path.find_last_of(".[");
  return end == std::string::npos ? "" : path.substr(0, end);
}

Place nearest_place(const Scene& scene, std::string path) {
  while (!scene.places.contains(path) && !path.empty()) path = parent_path(path);
  const auto found = scene.places.find(path);
  return found == scene.places.end() ? Place{} : found->second;
}

}  // namespace

SceneError scene_error(const Scene& scene, const std::string& path, const std::string& what) {
  const std::string field = path.empty() ? "" : path + ": ";
  if (scene.file.empty()) return SceneError(field + what);
  const Place place = nearest_place(scene, path);
  if (place.line == 0) return SceneError(scene.file + ": " + field + what);
  return SceneError(scene.file + ":" + std::to_string(place.line) + ":" + std::to_string(place.column) + ": " + field +
                    what);
}

std::string child_path(const std::string& parent, const std::string& field) {
  return parent.empty() ? field : parent + "." + field;
}

std::string child_path(const std::string& parent, std::size_t index) {
  return parent + "[" + std::to_string(index) + "]";
}

}  // namespace acus
