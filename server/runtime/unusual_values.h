// SPDX-License-Identifier: GPL-3.0-or-later
// Values of a scene that no tissue, needle or machine has: most were meant in another unit, which the remedy names.
#pragma once

#include "server/engine/scene/scene.h"
#include "server/runtime/scene_warning.h"

namespace acus {

void warn_of_unusual_values(const Scene& scene, SceneWarnings& found);

}  // namespace acus
