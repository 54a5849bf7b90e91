// SPDX-License-Identifier: GPL-3.0-or-later
// The disc of a surface, or of a border inside, that bears the contact of a tip. On a single point of a mesh a force
// above E a² inverts elements of size a, and the tip would lose its contact. So the force is spread over a disc twice
// as wide as the dimple that it presses (models/unresolved/dimple.h). kPatchPoints points, each in the middle of an
// equal share of the disc, are laid out around the contact point in the tissue at rest and projected onto the surface
// where that faces within 45 degrees of the contact, 90 on a border: past an edge two faces are equally near. A point
// projected over the distance w, beyond an edge, has the share 1/(1 + (4 w/radius)²)².
//
// The patch moves by the mean u of its points, dual to its force. Its rise, N·(C - X), is the height at rest of the
// surface at the contact point C over the mean X of the points, N the patch's normal at rest; 0 on a flat surface. The
// contact's normal is the mean normal under the points: the pit that a tip presses into a few elements has walls that
// real tissue has not, and the tip would slide along them.
#pragma once

#include <array>
#include <span>

#include "server/engine/state/capacities.h"
#include "server/engine/tick/views.h"

namespace acus {

struct ContactPatch {
  std::array<MaterialPoint, kPatchPoints> points;  // their weights are shares, which sum to 1
  double rise = 0;                    // m
  Vector3 middle = Vector3::Zero();   // m, world, their mean at the start of the tick
  Vector3 normal = Vector3::UnitZ();  // unit, world, likewise
};

// Around a point of a surface: the tissue's, or that of a region inside; radius (m) > 0.
ContactPatch make_contact_patch(const TissueView& tissue, const Surface& surface, const MaterialPoint& centre,
                                double radius);

// Whether an element of one of the points is pressed flat: the limit of what the mesh can bear.
bool is_crushed(const TetrahedralMesh& mesh, const Matrix3X& x, std::span<const MaterialPoint> points);

// The mean of points whose weights are shares, in the configuration x (3 x nodes, m).
Vector3 mean_position(const TetrahedralMesh& mesh, const Matrix3X& x, std::span<const MaterialPoint> points);

}  // namespace acus
