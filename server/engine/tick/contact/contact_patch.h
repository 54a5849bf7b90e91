// SPDX-License-Identifier: GPL-3.0-or-later
// The disc of a surface, or of a border inside, that bears the contact of a tip. On a single point of a mesh a force
// above E a² inverts elements of size a, and the tip would lose its contact. So the force is spread over a disc twice
// as wide as the dimple that it presses (models/unresolved/dimple.h). kPatchPoints points, each in the middle of an
// equal share of the disc, are laid out around the contact point in the tissue at rest, across the mean normal N there
// of the surface as far as the needle is wide (Surface::mean_normal), and projected onto the surface where that faces
// within 90 degrees of N. A point projected over the distance w has the share 1/(1 + (4 w/radius)²)². So the disc turns
// over an edge as the needle slides over it by its width.
//
// The patch moves by the mean u of its points, dual to its force. Its rise, N·(C - X), is the height at rest of the
// surface at the contact point C over the mean X of the points; 0 on a flat surface. The contact's normal is N, turned
// as the normals under the points have turned in the mean: the pit that a tip presses into a few elements has walls
// that real tissue has not, and the tip would slide along them.
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

// Around a point of a surface: the tissue's, or that of a region inside; radius (m) > 0, and width
// of what it bears (m), 0 on a border, whose edges are the mesh's: there N is the mean of the normals under the points.
ContactPatch make_contact_patch(const TissueView& tissue, const Surface& surface, const MaterialPoint& centre,
                                double radius, double width);

// Whether an element of one of the points is pressed flat: the limit of what the mesh can bear.
bool is_crushed(const TetrahedralMesh& mesh, const Matrix3X& x, std::span<const MaterialPoint> points);

// The mean of points whose weights are shares, in the configuration x (3 x nodes, m).
Vector3 mean_position(const TetrahedralMesh& mesh, const Matrix3X& x, std::span<const MaterialPoint> points);

}  // namespace acus
