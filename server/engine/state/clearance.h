// SPDX-License-Identifier: GPL-3.0-or-later
// What stands in the way of a needle where it is put: tissue around its tip, another needle.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "server/engine/models/geometry/tetrahedral_mesh.h"
#include "server/engine/models/needle/needle.h"
#include "server/engine/scene/scene.h"

namespace acus {

// Whether the tip of a straight or curved needle is inside the tissue, its nodes at x (3 x nodes, m), where its base is
// at `base`.
bool tip_is_inside(const TetrahedralMesh& mesh, const Matrix3X& x, const NeedleModel& needle, const Pose& base);

// Two needles of which one is in the other.
struct Overlap {
  int first = 0, second = 0;
  double depth = 0;  // m, where it is deepest,
  double at = 0;     // m, along the second one
};
// Of the first two that are found, where the scene keeps needles apart.
std::optional<Overlap> find_overlap(const Scene& scene, std::span<const NeedleModel> models,
                                    std::span<const NeedleState> needles);
std::string sentence(const Scene& scene, const Overlap& overlap);

}  // namespace acus
