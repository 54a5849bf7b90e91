// SPDX-License-Identifier: GPL-3.0-or-later
// One tick of the tissue: backward Euler, linearised about x_k,
//
//   A dx = -g(x_k) + Hᵀ lambda
//   g(x) = M((x - x_n)/h - v_n)/h + f(x) + B (x - x_n)/h - w
//
// with A of tissue_system.h. Matrix `constant`: f(x) = K0 (x - X). Matrix `turned`: A = R A0 Rᵀ with R the nodes' rotations
// and exact forces f, so the resting shape is that of the corotational model itself; residual and rows are turned into
// the rest frame (Rᵀ), the answer back. One linearisation is a tick of rung warped; repeated, the steps are those of a
// quasi-Newton method. Matrix `refactorized`: A = M/h² + B/h + K(x_k) at every call, K the exact Hessian (R K0 Rᵀ where
// that is indefinite), B = alpha M + beta R K0 Rᵀ at the start of the tick.
//
// With y = L⁻¹ (-g) the rows (tissue_rows.h) enter as dx = L⁻ᵀ (y + Y S lambda).
//
// Steps. For the lambda found dx goes down the merit Phi whose gradient is g(x) - Hᵀ lambda, at first with the slope
// -d, d = dxᵀ A dx = |y + Y S lambda|². Elements that are strained much, or swell near nu = 0.5 (the stiffness against
// turning then grows by lambda tr E), are stiffer than A knows. The slope at the end of a share s of the step,
//
//   -d + s dxᵀ (M/h² + B/h) dx + dxᵀ (f(x + s dx) - f(x)),
//
// tells: where it is above d, Phi has risen by the trapezoid rule, and so may kinetic and elastic energy together have
// without work done. Then s is cut by the secant rule. It costs an evaluation of the elements, so it is done where a
// node moves far for its element, where a repeated step is no shorter than the one before, and for kGuardedTicks after a
// step whose end, known in the next tick, was too steep. The damping of the first step is that of a turned A, by the
// largest beta, which is never too small; otherwise that of the elements, as in g.
//
// Everything here is scratch of one tick, from begin() to commit(). What lasts is TissueState. The corridor is a cache:
// no result depends on what it holds.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "server/engine/models/material_point.h"
#include "server/engine/models/tissue_rows.h"
#include "server/engine/models/tissue_system.h"

namespace acus {

class TissueMotion {
 public:
  static constexpr int kGuardedTicks = 100;  // linearisations
  static constexpr int kMaxTrials = 8;       // of shares, in one step

  // `max_nodes`: the most nodes that rows of one tick touch. The system must outlive this.
  TissueMotion(const TissueSystem& system, int max_rows, int max_nodes);
  TissueMotion(const TissueMotion&) = delete;
  TissueMotion& operator=(const TissueMotion&) = delete;

  void begin(const TissueState& state);

  // True unless an indefinite Hessian was replaced.
  bool linearize(const TissueState& state);

  void clear_rows() { rows_->clear(); }
  // Adds a row whose unit force acts on the tissue as `force` at a point; -1 if the corridor is full.
  int add_row(const TissuePoint& point, const Vector3& force);
  // Likewise, over several points whose weights sum to 1 all together.
  int add_row(std::span<const MaterialPoint> points, const Vector3& force);
  // Adds a row whose unit force turns the material of a tetrahedron by a couple `torque` (m): the nodal forces
  // 1/2 torque x grad N_k, dual to material_rotation(). -1 if the corridor is full.
  int add_couple(int tetrahedron, const Vector3& torque);
  // Adds a row that does not act on the tissue.
  int add_empty_row();
  // Adds W_t (m/N) of all rows, in the order in which they were added, to the lower triangle of W, and their free
  // displacements (m) to `delta`.
  void add_compliance(Eigen::Ref<MatrixX> W, std::span<double> delta) { rows_->add_compliance(y_, W, delta); }

  // Makes ready what rows on a tetrahedron will need, one node at a call, and keeps what there is from being given away
  // soon; false if all is there or there is no room.
  bool prepare(int tetrahedron);
  // Forgets the compliance that is kept.
  void clear_corridor() { rows_->corridor().clear(); }

  // Solves with the rows' forces (N).
  void solve(std::span<const double> lambda);
  // The share of the step, in (0, 1], that the forces at its end bear out.
  double trusted_share();
  // Moves x_k by a share of the step and returns the largest change of a coordinate (m).
  double move(double share);
  // All of it, trusted or not.
  double correct(std::span<const double> lambda) {
    solve(lambda);
    return move(1);
  }
  // Takes the tick over into the state.
  void commit(TissueState& state);
  bool finite() const { return x_.allFinite() && step_.allFinite(); }
  bool inverted() const { return inverted_; }  // an element was, at any linearize() since begin()

  const Matrix3X& x() const { return x_; }  // x_k (m)
  Precision precision() const { return factor().precision(); }
  int corridor_nodes() const { return rows_->corridor().capacity(); }

  // Sums for the balance of forces (N, world). The elastic part of the supports' force is known only at the next
  // linearize(), which evaluates the elements there; balance() then speaks of the tick before.
  struct Balance {
    Vector3 support = Vector3::Zero();  // by the fixed nodes' supports on the tissue
    Vector3 weight = Vector3::Zero();   // of the free nodes
    Vector3 inertia = Vector3::Zero();  // M a and mass-proportional drag of the free nodes
  };
  const Balance& balance() const { return balance_; }

 private:
  const SparseCholesky& factor() const { return own_factor_ ? *own_factor_ : system_.factor; }
  bool is(TissueMatrix matrix) const { return system_.matrix == matrix; }
  void begin_row();
  bool add_node(int node, const Vector3& force);
  bool add_part(const MaterialPoint& point, const Vector3& force);
  void evaluate(const TissueState& state);
  void judge_step(const TissueStep& first);
  double resistance(const Matrix3X& step, double descent, const ElementRotations& rotations, bool first);
  void put_residual(const TissueState& state);
  void evaluate_damping(const TissueState& state);
  bool refactorize();
  Quaternion rotation(int node) const {
    return {rotations_(0, node), rotations_(1, node), rotations_(2, node), rotations_(3, node)};
  }
  Vector3 to_factor(int node, const Vector3& world) const {
    return is(TissueMatrix::turned) ? Vector3(rotation(node).conjugate() * world) : world;
  }
  auto in_factor(int free) { return y_.segment<3>(system_.position[static_cast<std::size_t>(free)]); }

  const TissueSystem& system_;
  const TissueModel& model_;
  std::optional<SparseCholesky> own_factor_;  // refactorized
  MatrixX panel_rows_;                        // scratch
  std::optional<TissueRows> rows_;            // made once there is a factor

  // The iterate.
  int iteration_ = 0;                         // of this tick, those done
  Matrix3X x_;                                // x_k
  Matrix3X elastic_;                          // dPsi/dx at x_k
  ElementRotations element_rotations_;        // there
  ElementRotations start_rotations_;          // of the tick, from its second iteration on
  Matrix4X rotations_;                        // turned: of the nodes, made smooth
  Matrix4X rotation_sums_;                    // memory for that
  VectorX y_;                                 // in the factor's order
  bool inverted_ = false;

  // The step.
  Matrix3X step_;                             // dx, zero for fixed nodes (m)
  double descent_ = 0;                        // d (J)
  double last_descent_ = 0;                   // of the iteration before in this tick, infinite in the first (J)
  TissueStep first_;                          // what the state will remember of the tick's first step
  int guarded_ = 0;                           // linearisations in which steps are looked at

  // Memory.
  ElementScratch elements_;
  Matrix3X trial_x_, trial_forces_;           // at the end of a share of the step
  ElementRotations trial_rotations_;
  Matrix3X velocity_;                         // of the nodes in this tick; also a displacement, for constant
  Matrix3X damping_force_;                    // of the damping of the stiffness, from the tick's second iteration on
  SparseMatrix damping_, matrix_;             // refactorized: beta K of this tick, lower triangle; A
  std::vector<Vector3> on_fixed_;             // per row, the sum of its forces on fixed nodes, world
  Vector3 lambda_on_fixed_ = Vector3::Zero();
  Balance balance_;
};

}  // namespace acus
