// SPDX-License-Identifier: GPL-3.0-or-later
// What a mesh file has given a scene: how it was read, its groups, and which regions name them.
#pragma once

#include <string>

#include "server/engine/tick/simulation.h"
#include "server/runtime/scene_warning.h"

namespace acus {

// Columns of text, empty for a mesh from no file.
std::string summarise_mesh_file(const Simulation& simulation);

// Two groups or more that no region names.
void warn_of_unnamed_groups(const Simulation& simulation, SceneWarnings& found);

}  // namespace acus
