// SPDX-License-Identifier: GPL-3.0-or-later
// What holds a needle sideways at a place of its path: the springs of the tissue beside it, from the path's place to
// the needle's, and the force T that the tissue bears before it tears (tearing.h).
#pragma once

#include <optional>

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Shortest length (m) that supports a vertex.
inline constexpr double kLeastSupported = 1e-6;
// Across a shaft of diameter d (m), of the tissue beside a vertex with that length, beyond the mesh (m/N).
double beside_compliance(const TissueView& tissue, const MaterialPoint& p, double d, double supported);

// What holds a needle sideways at a place of its path.
struct HeldPlace {
  MaterialPoint material;
  Vector3 tangent;    // of the path, unit, world
  Vector3 apart;      // m, world, of the needle from there, with what springs have crept
  double compliance;  // m/N, of the springs
  double strength;    // T (N), .inf allowed
};

// `needle`: its place (m, world) at the vertex; `dimpled`: beside_dimple() there.
HeldPlace held_vertex(const InsertionView& at, const MaterialPoint& vertex, const ShaftPoint& point,
                      const Vector3& needle, const Vector3& dimpled, const Creep& creep);
HeldPlace held_tip(const InsertionView& at, const TipPlace& tip, const Creep& creep);

// `last`: the force of the last tick, on the needle (N, world). None if the path is far from tearing.
std::optional<TearLimit> tear_limit(const InsertionView& at, const HeldPlace& place, const Vector3& last);

// A force on the needle, or its way, at a place of its path, without its part along what a border there bears.
Vector3 borne_by_path(const TissueView& tissue, const MaterialPoint& place, const Vector3& vector);

}  // namespace acus
