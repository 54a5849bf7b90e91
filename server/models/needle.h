// SPDX-License-Identifier: GPL-3.0-or-later
// A flexible needle: a chain of corotational beams (beam_element.h), node 0 held at the base pose that the user
// prescribes, the others free. Nodes carry a position and an orientation whose +x axis is the needle's tangent.
//
// One tick solves, linearised about the configuration q_k,
//
//   (M/h² + B/h + K) dq = -g(q_k) + Hᵀ lambda
//   g(q) = M((q - q_n)/h - v_n)/h + f(q) + B (q - q_n)/h - w
//
// with lumped M, B = alpha M + beta K_m, K the exact Hessian of the elastic energy and K_m its material part. q_0 is
// q_n carried along rigidly with the base, so that a turn of the base stretches no beam. The stiffness-proportional
// damping acts on q - q_0 alone: a rigid motion is not damped by it.
//
// What rows see of it, H A⁻¹ Hᵀ, is formed without solving for each (needle_compliance.h).
//
// An unloaded needle is straight for straight_length and then a circular arc in its base's x-y plane. A curved beam is
// the straight beam of beam_element.h along its chord, with each node's frame turned by a constant rotation to where it
// agrees with the chord at rest. That turn acts from the right and rotation increments act from the left, so forces and
// Hessian stay exact. The nodes lie on the arc exactly; a beam's stiffness is that of a straight one as long as the
// chord, which is off by (curvature x beam length)²/24 of itself.
//
// Reaction at the base. Of a flexible needle it is the residual of node 0, g_0 + A_01 dq_1 - (Hᵀ lambda)_0. A rigid
// needle has no free nodes: dq = 0, W_n = 0, and its reaction is inertia, with mass-proportional drag, - weight
// - Hᵀ lambda, summed over the nodes about the base: a command that jerks is felt as it is, without the compliance of a
// shaft.
#pragma once

#include <span>
#include <vector>

#include "server/math/block_tridiagonal.h"
#include "server/math/types.h"
#include "server/models/beam_element.h"
#include "server/models/material.h"
#include "server/models/needle_compliance.h"

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

  int nodes() const { return beams + 1; }
  double beam_length() const { return stiffness.length; }
};

// The arc turns by less than half a turn along a beam: |curvature| x length / beams < pi.
NeedleModel make_needle_model(const NeedleBody& body, const Vector3& gravity, bool rigid = false);

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
// tangents, p = H00 x1 + H01 x2 + L (H10 t1 + H11 t2); beyond the ends the tangent goes on.
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
double potential_energy(const NeedleModel& model, const NeedleState& state);

CurvePoint curve_point(const NeedleModel& model, const NeedleShape& shape, double s);

// Hᵀ n for a force along n at the point: generalised forces on the two nodes of its beam, (f1, m1, f2, m2).
Vector12 curve_force(const NeedleShape& shape, const CurvePoint& point, const Vector3& n);

// Hᵀ for a couple at the point, shared between the nodes of its beam as the rotation there is,
// (1 - u) theta1 + u theta2.
Vector12 curve_torque(const CurvePoint& point, const Vector3& torque);

// The tick's linear system and its memory.
class NeedleMotion {
 public:
  static constexpr double kLargeTurn = 0.05;  // rad, of a node in a step, to be looked at
  static constexpr int kMaxTrials = 8;        // of shares, in one step

  NeedleMotion(const NeedleModel& model, double h, int max_rows);

  // Starts a tick from `state` with the base at its new pose.
  void begin(const NeedleState& state, const Pose& base);

  // Linearises about the current configuration and solves for the free motion. True if the exact tangent was positive
  // definite.
  bool linearize(const NeedleState& state);

  void clear_rows() { rows_.clear(); }
  // Adds a row whose generalised force is `force` on the nodes of `beam`; returns its index.
  int add_row(int beam, const Vector12& force);
  // Adds W_n (m/N) to the lower triangle of W; row r of the needle is row places[r] there.
  void add_compliances(std::span<const int> places, Eigen::Ref<MatrixX> W);
  double free_displacement(int row) const;  // H dq_free (m)

  // Solves with the rows' forces (N).
  void solve(std::span<const double> lambda);
  // Whether a node turns by more than kLargeTurn in the step: too far for a linearisation that is made but once.
  bool turns_far() const;
  // The share of the step, in (0, 1], that the forces at its end bear out: a beam that turns by theta in a step is
  // stretched by L theta²/2, of which the linearisation knows nothing. As in tissue_motion.h, with every term of g.
  double trusted_share(const NeedleState& state);
  // Moves by a share of the step and returns the largest change of a position (m).
  double move(double share);
  // All of it, trusted or not.
  double correct(std::span<const double> lambda) {
    solve(lambda);
    return move(1);
  }

  // Holder on needle at node 0 (N, N m, world), valid after correct().
  const Vector6& base_reaction() const { return reaction_; }

  // Sum over the nodes of inertia and mass-proportional drag less weight (N), of the tick that commit() will end. The
  // base's reaction and the forces of the laws add up to it.
  Vector3 inertia_less_weight(const NeedleState& state) const;

  // What a displacement (translation m, rotation vector rad, world) of the base at the end of the tick does while the
  // rows' forces stay, by the linearisation of the last step; see base_stiffness.h.
  //
  // How the free nodes follow: 6 x free nodes rows, 6 columns.
  Eigen::Index free_unknowns() const { return dq_.size(); }
  void follow_base(Eigen::Ref<MatrixX> dq) const;
  // d(delta)/d(displacement) of a row (-, m), given how the free nodes follow.
  Vector6 follow_base(int row, const Eigen::Ref<const MatrixX>& dq) const;
  // d(base_reaction())/d(displacement), given the same; symmetric, N/m, N, N m.
  Matrix6 base_tangent(const Eigen::Ref<const MatrixX>& dq) const;

  // Of the tick that commit() will end.
  struct EnergyChange {
    double stored;  // J, kinetic and elastic, at the end
    double gained;  // J, what is stored beyond what was stored before and the work of base, laws and weight. Backward
                    // Euler and damping take: it is not above zero where ticks follow the needle
  };
  EnergyChange energy_change(const NeedleState& state) const;
  // Of all beams: |l/L - 1| of the chord and curvature times radius (-).
  double largest_strain() const;

  // Takes the configuration over into the state.
  void commit(NeedleState& state) const;
  bool finite() const;

  const NeedleShape& shape() const { return iterate_.shape; }

 private:
  struct Configuration {
    NeedleShape shape;
    std::vector<Quaternion> q;
  };

  void add_beams(bool exact);
  Matrix3 beam_turn(const Configuration& at, int beam) const;
  Matrix12 turned_material(const Configuration& at, int beam) const;
  Vector12 beam_damping_force(const Configuration& at, int beam, const Matrix12& turned_material) const;
  void put_residual(const NeedleState& state, const Configuration& at, Matrix6X& g) const;
  void add_inertia(const NeedleState& state);
  Vector6 inertia_force(const NeedleState& state, const Configuration& at, int node) const;
  Vector6 velocity(const NeedleState& state, int node) const;
  Vector6 about_base(int node, const Vector6& wrench) const;
  void add_inertia_tangent(int node, Matrix6& block) const;
  Vector6 add_row_forces(std::span<const double> lambda);
  void go(double share, Configuration& to) const;

  const NeedleModel& model_;
  double h_;
  Configuration iterate_;                   // q_k
  Configuration rigid_;                     // q_0
  Configuration trial_;                     // at the end of a share of the step
  std::vector<Matrix12> material_;          // K_m per beam at q_0
  bool at_rigid_ = true;                    // q_k is still q_0
  Matrix6X g_;                              // residual per node; of a rigid needle all of it in column 0
  Matrix6X trial_g_;                        // likewise, at trial_
  BlockTridiagonal matrix_;                 // nodes 1..n; of a rigid needle empty, like dq and dq_free
  Matrix6 base_coupling_;                   // A(0, 1)
  Matrix6 base_diagonal_ = Matrix6::Zero();  // A(0, 0), inertia left out
  NeedleCompliance compliance_;
  std::vector<BeamRow> rows_;
  VectorX dq_free_, dq_;
  VectorX applied_;                         // Hᵀ lambda on the free nodes
  Vector6 on_base_ = Vector6::Zero();       // Hᵀ lambda on node 0
  Vector6 reaction_ = Vector6::Zero();
};

}  // namespace acus
