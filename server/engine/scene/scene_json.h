// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes for programs that read no YAML.
#pragma once

#include <string>

#include "server/engine/scene/scene.h"

namespace acus {

// What the text of a scene says: the fields that stand there and no others. An infinity is written 1e999, which is
// JSON, and which readers with numbers of double precision take for one.
std::string scene_as_json(const Scene& scene);

}  // namespace acus
