// SPDX-License-Identifier: GPL-3.0-or-later
// Builds the messages of SceneError: "file:line:column: field: what".
#pragma once

#include <string>

#include "server/engine/scene/scene.h"

namespace acus {

// About the field at `path`. A field that the file leaves out is placed at the nearest one around it; a scene built in
// code has no places and its messages open with the field.
SceneError scene_error(const Scene& scene, const std::string& path, const std::string& what);

// "tissue" + "mesh" -> "tissue.mesh"; the top level has the empty path.
std::string child_path(const std::string& parent, const std::string& field);
std::string child_path(const std::string& parent, std::size_t index);

}  // namespace acus
