// SPDX-License-Identifier: GPL-3.0-or-later
// Whether the mesh resolves its regions: a tetrahedron belongs to a region by its centroid, so that a region thinner
// than some cells falls into pieces that share no face, or has another volume than its shape.
#pragma once

#include "server/engine/tick/simulation.h"
#include "server/runtime/scene_warning.h"

namespace acus {

void warn_of_unresolved_regions(const Simulation& simulation, SceneWarnings& found);

}  // namespace acus
