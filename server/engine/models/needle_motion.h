// SPDX-License-Identifier: GPL-3.0-or-later
// The motion of a needle (needle.h) in a tick, which solves, linearised about the configuration q_k,
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
// A needle that is pressed by more than it could bear with a free tip has a tangent that is not positive definite,
// though it stands: what its end sticks in keeps it from giving way. As that is no part of the tangent, springs across
// its end stand in for it there, kHoldStep^i x 3 EI/L³ for i = 1 up to the first that suffices. They hold on to q_k, so
// they put no force into g: they shorten steps and leave equilibria where they are. A needle that gives way in spite of
// them buckles, and the material part is its tangent.
//
// A base that is held adds a step u of node 0, six unknowns. With F = -A⁻¹ A_10 what the free nodes make of it, G = H_0
// + H F what rows see of it, S = A_00 + A_01 F and K the holder's tangent, what stands above for u = 0 becomes
//
//   u = (S + K)⁻¹ (w - r + Gᵀ lambda),   W_n += G (S + K)⁻¹ Gᵀ,   dq += F u
//
// w the holder's wrench and r the reaction below, both before the step and without the rows' forces.
//
// Reaction at the base. Of a flexible needle it is the residual of node 0, g_0 + A_01 dq_1 - (Hᵀ lambda)_0. A rigid
// needle has no free nodes: dq = 0, W_n = 0, and its reaction is inertia, with mass-proportional drag, - weight
// - Hᵀ lambda, summed over the nodes about the base: a command that jerks is felt as it is, without the compliance of a
// shaft.
#pragma once

#include <Eigen/Cholesky>
#include <optional>
#include <span>
#include <vector>

#include "server/engine/math/block_tridiagonal.h"
#include "server/engine/math/types.h"
#include "server/engine/models/held_base.h"
#include "server/engine/models/needle.h"
#include "server/engine/models/needle_compliance.h"

namespace acus {

// The tick's linear system and its memory.
class NeedleMotion {
 public:
  static constexpr double kLargeTurn = 0.05;  // rad, of a node in a step, to be looked at
  static constexpr int kMaxTrials = 8;        // of shares, in one step
  static constexpr int kMaxHolds = 3;         // of springs across the end, in one linearisation
  static constexpr double kHoldStep = 8;      // from one to the next

  NeedleMotion(const NeedleModel& model, double h, int max_rows);

  // Starts a tick from `state` with the base, or what holds it, at its new pose; `before` is where what holds it was.
  void begin(const NeedleState& state, const Pose& base, const Pose& before);
  void begin(const NeedleState& state, const Pose& base) { begin(state, base, base); }

  // Linearises about the current configuration and solves for the free motion. `held` is the number of nodes, from the
  // tip, that tissue keeps from going aside. True if the exact tangent was positive definite.
  bool linearize(const NeedleState& state, int held = 0);

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

  // The forces of the rows and the weight together, about node 0 (N, N m, world), valid after correct(): what the
  // needle would hand on to its holder if it stood still, inertia and damping left out.
  Vector6 lasting_wrench() const;

  // What a displacement (translation m, rotation vector rad, world) of the base at the end of the tick, or of what
  // holds it, does while the rows' forces stay, by the linearisation of the last step; see base_stiffness.h.
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
  void add_springs(int held, double stiffness);
  bool try_tangent(const NeedleState& state, bool exact, int held = 0, double stiffness = 0);
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
  bool put_free_motion();
  void go(double share, Configuration& to) const;
  void step_node(int node, const Vector6& step, Configuration& to) const;
  Vector3 step_of_tip() const;
  void turn_about_base(double share, Configuration& to) const;
  Pose base_of(const Configuration& at) const { return {at.shape.x.col(0), at.q[0]}; }

  void follow_node(Eigen::Ref<MatrixX> dq) const;                           // F
  Vector6 follow_node(int row, const Eigen::Ref<const MatrixX>& dq) const;  // a row of G
  Matrix6 node_tangent() const;                                             // A(0, 0)
  Matrix6 tangent_beside(const Eigen::Ref<const MatrixX>& dq) const;        // S
  Matrix6 share_of_holder() const;
  bool close_at_base();
  void add_base_compliances(std::span<const int> places, Eigen::Ref<MatrixX> W);

  const NeedleModel& model_;
  double h_;
  Configuration iterate_;                    // q_k
  Configuration rigid_;                      // q_0
  Configuration trial_;                      // at the end of a share of the step
  std::vector<Matrix12> material_;           // K_m per beam at q_0
  bool at_rigid_ = true;                     // q_k is still q_0
  Matrix6X g_;                               // residual per node; of a rigid needle all of it in column 0
  Matrix6X trial_g_;                         // likewise, at trial_
  BlockTridiagonal matrix_;                  // nodes 1..n; of a rigid needle empty, like dq and dq_free
  Matrix6 base_coupling_;                    // A(0, 1)
  Matrix6 base_diagonal_ = Matrix6::Zero();  // A(0, 0), inertia left out
  NeedleCompliance compliance_;
  std::vector<BeamRow> rows_;
  std::optional<HeldBase> held_;                          // and of a base that is held alone:
  MatrixX follow_;                                        // F
  Eigen::LLT<Matrix6> base_factor_{Matrix6::Identity()};  // of S + K
  Eigen::Matrix<double, Eigen::Dynamic, 6> base_rows_;    // G, times the factor's inverse
  Vector6 base_free_ = Vector6::Zero();                   // u without the rows' forces
  Vector6 base_step_ = Vector6::Zero();                   // u
  VectorX dq_free_, dq_;
  VectorX applied_;                    // Hᵀ lambda on the free nodes
  Vector6 on_base_ = Vector6::Zero();  // Hᵀ lambda on node 0
  Vector6 reaction_ = Vector6::Zero();
};

}  // namespace acus
