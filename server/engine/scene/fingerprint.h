// SPDX-License-Identifier: GPL-3.0-or-later
// Which scene it is, as a number: of everything in it that a tick depends on. Not of its name and colours, of what is published how
// often, nor of where its mesh lies; of the mesh itself.
#pragma once

#include <cstdint>

#include "server/engine/scene/scene.h"

namespace acus {

// `mesh` is the scene's, at its place in the world; `regions` per tetrahedron.
std::uint64_t fingerprint(const Scene& scene, const TetrahedralMesh& mesh, std::span<const int> regions);

}  // namespace acus
