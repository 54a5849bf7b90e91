// SPDX-License-Identifier: GPL-3.0-or-later
// The disc of a surface that bears a tip's contact. On one point of a mesh a force above E a² turns elements of size a
// inside out; the tip would then lose its contact and go on through tissue that it does not feel. So the force is
// spread over a disc as wide as the dimple that it presses (local_compliance.h): kPatchPoints points, each in the
// middle of an equal share of the disc, are laid out around the point of contact in the tissue at rest and brought onto
// its surface, as far as that faces within 45 degrees of where the contact is: past an edge, both faces are as close,
// and rounding would choose. Those that come from far, beyond an edge, bear less: 1/(1 + (4 way/radius)²)² of a share.
//
// The patch moves by the mean u of its points, dual to its force. Where the surface at the point of contact C stands
// over that mean X at rest is its rise, N·(C - X) with N the patch's normal at rest: 0 on a flat surface.
// The contact's normal is the mean of the surface's under the points: the pit that a tip presses into a few elements
// has walls, which the tissue has not, and a tip would slide along them.
#pragma once

#include <array>
#include <span>

#include "server/engine/tick/views.h"

namespace acus {

inline constexpr int kPatchPoints = 21;  // one, eight and twelve around it

struct ContactPatch {
  std::array<MaterialPoint, kPatchPoints> points;  // their weights are shares, which sum to 1
  double rise = 0;                    // m
  Vector3 middle = Vector3::Zero();   // m, world, their mean at the start of the tick
  Vector3 normal = Vector3::UnitZ();  // unit, world, likewise

  std::span<const MaterialPoint> all() const { return points; }
};

// Around a point of the tissue's surface; radius (m) > 0.
ContactPatch make_contact_patch(const TissueView& tissue, const MaterialPoint& centre, double radius);

// The mean of its points in the configuration x (3 x nodes, m).
Vector3 mean_position(const TetrahedralMesh& mesh, const Matrix3X& x, const ContactPatch& patch);

}  // namespace acus
