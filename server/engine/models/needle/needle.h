// SPDX-License-Identifier: GPL-3.0-or-later
// A flexible needle: a chain of corotational beams (beam_element.h), node 0 held at the base pose that the user
// prescribes, or to it by a spring and a damper (held_base.h), the others free. Nodes carry a position and an
// orientation whose +x axis is the needle's tangent.
//
// An unloaded needle is straight for straight_length and then a circular arc in its base's x-y plane. A curved beam is
// the straight beam of beam_element.h along its chord, with each node's frame turned by a constant rotation to where it
// agrees with the chord at rest. That turn acts from the right and rotation increments act from the left, so forces and
// Hessian stay exact. The nodes lie on the arc exactly; a beam's stiffness is that of a straight one as long as the
// chord, which is off by (curvature x beam length)²/24 of itself.
//
// needle_linearization.h and needle_step.h move it by a tick.
#pragma once

#include <optional>
#include <vector>

#include "server/engine/math/factor/block_tridiagonal.h"
#include "server/engine/math/types.h"
#include "server/engine/models/element/material.h"
#include "server/engine/models/needle/beam_element.h"

namespace acus {

using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;

// The unloaded shape of a curved beam.
struct CurvedBeam {
  double chord;               // m, between its nodes
  Matrix3 first_from_chord;   // turns the first node's frame, from the right, into the chord's
  Matrix3 second_from_chord;  // and the second node's
};

// Constant after load.
struct NeedleModel {
  int beams = 0;
  double length = 0;                  // m
  double diameter = 0;                // m, outer
  bool rigid = false;                 // no node moves against the base
  BeamStiffness stiffness{};          // of a straight beam
  double straight_length = 0;         // m, from the base; the rest is an arc
  double curvature = 0;               // 1/m, of the arc; positive bends it from +x towards +y
  int straight_beams = 0;             // the first ones
  std::vector<CurvedBeam> curved;     // beams - straight_beams, the others
  double rayleigh_mass = 0;           // alpha (1/s)
  double rayleigh_stiffness = 0;      // beta (s)
  VectorX mass;                       // kg, lumped, per node
  VectorX inertia_axial;              // kg m², lumped, about the tangent
  VectorX inertia_transverse;         // kg m², lumped, about any axis across
  Vector3 gravity = Vector3::Zero();  // m/s²
  std::optional<BaseHold> hold;       // of the base; none: it is where it is told

  int nodes() const { return beams + 1; }
  double beam_length() const { return stiffness.length; }
};

// The arc turns by less than half a turn along a beam: |curvature| x length / beams < pi.
NeedleModel make_needle_model(const NeedleBody& body, const Vector3& gravity, bool rigid = false,
                              const std::optional<BaseHold>& hold = std::nullopt);

// Where the unloaded needle is at arc length s (m) in its base's frame; +x of the pose is the tangent.
Pose rest_pose(const NeedleModel& model, double s);

// Where the needle is and how it moves; velocities are (linear, angular), world.
struct NeedleState {
  Matrix3X x;                     // 3 x nodes (m)
  std::vector<Quaternion> q;      // nodes, unit
  Matrix6X v;                     // 6 x nodes (m/s, rad/s)

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("x", self.x);
    visit("q", self.q);
    visit("v", self.v);
  }
};

// Unloaded and at rest: straight, or its arc, from the base along the base's +x axis.
NeedleState make_needle_state(const NeedleModel& model, const Pose& base);

// A configuration to evaluate the needle's curve in: node positions and frames (column 0 is the tangent).
struct NeedleShape {
  Matrix3X x;
  std::vector<Matrix3> frames;
};

// The shape of a state.
void put_shape(const NeedleState& state, NeedleShape& shape);

// A beam of the needle as beam_element.h takes it: straight when unloaded, along the chord.
struct NeedleBeam {
  BeamStiffness stiffness;
  BeamEnd a, b;
};

NeedleBeam needle_beam(const NeedleModel& model, const NeedleShape& shape, int beam);

// A point of the curve at arc length s (m, from the base). Within beam e it is the cubic with the nodes' positions and
// tangents, p = H00 x1 + H01 x2 + L (H10 t1 + H11 t2); beyond the ends the tangent continues.
struct CurvePoint {
  Vector3 position;
  Vector3 tangent;     // unit
  int beam;
  double u;            // -, 0 to 1 along the beam
  double h00, h01;     // -
  double h10, h11;     // m, beam length included
};

// What the needle stores (J); gravity's share is zero where the nodes are in the origin.
double elastic_energy(const NeedleModel& model, const NeedleShape& shape);
double kinetic_energy(const NeedleModel& model, const NeedleState& state);
// Of node i alone, with its axis along `axis` (unit) and its velocities v (linear, angular; world).
double kinetic_energy(const NeedleModel& model, int i, const Vector3& axis, const Vector6& v);
double potential_energy(const NeedleModel& model, const NeedleState& state);

CurvePoint curve_point(const NeedleModel& model, const NeedleShape& shape, double s);

// Hᵀ n for a force along n at the point: generalised forces on the two nodes of its beam, (f1, m1, f2, m2).
Vector12 curve_force(const NeedleShape& shape, const CurvePoint& point, const Vector3& n);

// Hᵀ for a couple at the point, shared between the nodes of its beam as the rotation there is,
// (1 - u) theta1 + u theta2.
Vector12 curve_torque(const CurvePoint& point, const Vector3& torque);

}  // namespace acus
