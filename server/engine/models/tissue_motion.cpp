// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue_motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "server/engine/math/step_share.h"

namespace acus {

namespace {

// Of the merit at the end of a share of a step (J): `resistance` is dxᵀ (M/h² + B/h) dx.
double merit_slope(double share, double descent, double resistance, const Matrix3X& step, const Matrix3X& start_forces,
                   const Matrix3X& end_forces) {
  return -descent + share * resistance + (end_forces - start_forces).cwiseProduct(step).sum();
}

}  // namespace

TissueMotion::TissueMotion(const TissueSystem& system, int max_rows, int max_nodes)
    : system_(system),
      model_(system.model),
      element_rotations_(model_),
      start_rotations_(element_rotations_),
      elements_(model_),
      trial_rotations_(element_rotations_) {
  x_ = trial_x_ = model_.mesh->nodes;
  elastic_.setZero(3, model_.nodes());
  step_ = trial_forces_ = velocity_ = damping_force_ = elastic_;
  rotations_.setZero(4, model_.nodes());
  rotations_.row(0).setOnes();
  rotation_sums_.setZero(4, system.rotation_grid.points);
  y_.setZero(model_.unknowns());
  on_fixed_.resize(static_cast<std::size_t>(max_rows));
  if (is(TissueMatrix::refactorized) && !system.empty()) {
    own_factor_.emplace();
    system.assembler.assemble(x_, element_rotations_, Tangent::rest, tick_factors(system.h), matrix_);
    own_factor_->analyze(matrix_, 3);
    own_factor_->factorize(matrix_);
  }
  panel_rows_ = factor().make_panel_rows();
  rows_.emplace(factor(), max_rows, max_nodes);
}

void TissueMotion::begin(const TissueState& state) {
  assert(state.x.cols() == model_.nodes() && state.v.cols() == model_.nodes());
  x_ = state.x;
  iteration_ = 0;
  inverted_ = false;
  guarded_ = state.guarded;
  first_ = {};
  rows_->corridor().begin_use();
}

// Elastic forces at x_k; on the first call of a tick also what the last tick's step came to, and its supports carried.
void TissueMotion::evaluate(const TissueState& state) {
  if (is(TissueMatrix::constant)) {
    system_.stiffness->forces(x_, velocity_, elastic_);
  } else {
    const ElementRotations& start = iteration_ == 0 ? state.rotations : element_rotations_;
    const bool inverted = elastic_forces(model_, x_, start, element_rotations_, elements_, elastic_);
    inverted_ = inverted_ || inverted;
    if (iteration_ == 0 && state.step.share > 0) {
      step_ = state.v * (system_.h / state.step.share);
      judge_step(state.step);
    } else if (iteration_ == 1) {
      judge_step(first_);
    }
  }
  if (is(TissueMatrix::turned)) {
    node_rotations(model_, element_rotations_, rotations_);
    smooth_rotations(system_.rotation_grid, rotations_, rotation_sums_);
  }
  if (iteration_ > 0) return;
  balance_ = {state.support, state.moved ? system_.weight : Vector3(Vector3::Zero()), state.inertia};
  for (const int i : model_.fixed_nodes) balance_.support += elastic_.col(i);
}

// Whether the end of a tick's first step `step_`, where the elastic forces are known by now, was too steep. Since the
// resistance is at most d, mostly the elastic forces alone say that it was not.
void TissueMotion::judge_step(const TissueStep& first) {
  const double rise = elastic_.cwiseProduct(step_).sum() - first.work;
  if (rise <= first.descent) return;
  const double end = -first.descent + first.share * resistance(step_, first.descent, element_rotations_, true) + rise;
  if (!(end <= first.descent)) guarded_ = kGuardedTicks;
}

bool TissueMotion::refactorize() {
  const double h = system_.h;
  // The Hessian at x_k; where it is indefinite, the turned rest stiffness, which never is.
  for (const Tangent tangent : {Tangent::exact, Tangent::turned}) {
    system_.assembler.assemble(x_, element_rotations_, tangent, {1 / (h * h), 1 / h, 1, 0}, matrix_);
    if (system_.damped)
      Eigen::Map<VectorX>(matrix_.valuePtr(), matrix_.nonZeros()) +=
          Eigen::Map<const VectorX>(damping_.valuePtr(), damping_.nonZeros()) / h;
    if (own_factor_->factorize(matrix_)) return tangent == Tangent::exact;
  }
  return false;
}

// -g at x_k into y, in the factor's frame and order.
void TissueMotion::put_residual(const TissueState& state) {
  const double h = system_.h;
  for (int f = 0; f < static_cast<int>(system_.position.size()); ++f) {
    const int i = model_.free_nodes[f];
    Vector3 residual = model_.mass[i] * (model_.gravity + state.v.col(i) / h) - elastic_.col(i);
    if (iteration_ > 0) {  // on the first, x_k = x_n
      const Vector3 velocity = (x_.col(i) - state.x.col(i)) / h;
      residual -= (model_.mass[i] / h + model_.mass_damping[i]) * velocity + damping_force_.col(i);
    }
    in_factor(f) = to_factor(i, residual);
  }
}

// The damping of the stiffness, beta R K0 Rᵀ (x_k - x_n)/h with R of the start of the tick.
void TissueMotion::evaluate_damping(const TissueState& state) {
  velocity_ = (x_ - state.x) / system_.h;
  damping_forces(model_, velocity_, start_rotations_, elements_, damping_force_);
}

bool TissueMotion::linearize(const TissueState& state) {
  if (system_.empty()) return true;
  if (iteration_ == 1) start_rotations_.batches = element_rotations_.batches;
  evaluate(state);
  if (system_.damped && iteration_ > 0) evaluate_damping(state);
  put_residual(state);
  bool exact = true;
  if (is(TissueMatrix::refactorized)) {
    if (system_.damped && iteration_ == 0)
      system_.assembler.assemble(x_, element_rotations_, Tangent::turned, {.stiffness_damping = 1}, damping_);
    exact = refactorize();
    clear_corridor();
  }
  ++iteration_;
  factor().forward(y_, panel_rows_);
  return exact;
}

void TissueMotion::begin_row() {
  rows_->begin();
  on_fixed_[rows_->count()].setZero();
}

bool TissueMotion::add_node(int node, const Vector3& force) {
  const int free = model_.free_index[node];
  if (free >= 0) return rows_->add_force(free, to_factor(node, force));
  on_fixed_[rows_->count()] += force;
  return true;
}

bool TissueMotion::add_part(const MaterialPoint& point, const Vector3& force) {
  const auto& nodes = model_.mesh->tetrahedra[point.tetrahedron];
  for (int k = 0; k < 4; ++k)
    if (point.weights[k] != 0 && !add_node(nodes[k], point.weights[k] * force)) return false;
  return true;
}

int TissueMotion::add_row(const TissuePoint& point, const Vector3& force) {
  begin_row();
  if (!add_part(point.a, (1 - point.u) * force)) return -1;
  if (point.u > 0 && !add_part(point.b, point.u * force)) return -1;
  return rows_->end();
}

int TissueMotion::add_row(std::span<const MaterialPoint> points, const Vector3& force) {
  begin_row();
  for (const MaterialPoint& point : points)
    if (!add_part(point, force)) return -1;
  return rows_->end();
}

int TissueMotion::add_couple(int tetrahedron, const Vector3& torque) {
  begin_row();
  const auto gradients = shape_gradients(*model_.mesh, x_, tetrahedron);
  for (int k = 0; k < 4; ++k)
    if (!add_node(model_.mesh->tetrahedra[tetrahedron][k], 0.5 * torque.cross(gradients.col(k)))) return -1;
  return rows_->end();
}

int TissueMotion::add_empty_row() {
  begin_row();
  return rows_->end();
}

bool TissueMotion::prepare(int tetrahedron) {
  if (is(TissueMatrix::refactorized)) return false;
  for (const int node : model_.mesh->tetrahedra[tetrahedron]) {
    const int free = model_.free_index[node];
    if (free < 0) continue;
    const bool made = !rows_->corridor().holds(free);
    if (rows_->corridor().slot(free) < 0) return false;
    if (made) return true;
  }
  return false;
}

void TissueMotion::solve(std::span<const double> lambda) {
  lambda_on_fixed_.setZero();
  if (system_.empty()) return;
  for (int r = 0; r < rows_->count(); ++r) lambda_on_fixed_ += lambda[r] * on_fixed_[r];
  rows_->add_forces(lambda, y_);
  last_descent_ = iteration_ > 1 ? descent_ : std::numeric_limits<double>::infinity();
  descent_ = y_.squaredNorm();
  factor().backward(y_, panel_rows_);
  for (int f = 0; f < static_cast<int>(system_.position.size()); ++f) {
    const int i = model_.free_nodes[f];
    step_.col(i) = is(TissueMatrix::turned) ? Vector3(rotation(i) * in_factor(f)) : Vector3(in_factor(f));
  }
}

// dxᵀ (M/h² + B/h) dx of a step (J), the elements turned as given; `first`: of a tick's first step.
double TissueMotion::resistance(const Matrix3X& step, double descent, const ElementRotations& rotations, bool first) {
  const double h = system_.h;
  double inertia = 0;
  for (const int i : model_.free_nodes)
    inertia += (model_.mass[i] / h + model_.mass_damping[i]) / h * step.col(i).squaredNorm();
  if (!system_.damped) return inertia;
  if (is(TissueMatrix::turned) && first) return descent - (descent - inertia) / (1 + system_.largest_damping / h);
  damping_forces(model_, step, rotations, elements_, damping_force_);
  return inertia + damping_force_.cwiseProduct(step).sum() / h;
}

double TissueMotion::trusted_share() {
  if (system_.empty() || is(TissueMatrix::constant)) return 1;
  const bool far = !(step_.cwiseAbs().maxCoeff() <= system_.large_step), longer = !(descent_ <= last_descent_);
  const bool looked_at = guarded_ > 0 || far || longer;
  if (!looked_at) return 1;
  const bool first = iteration_ == 1;
  const double resisting = resistance(step_, descent_, first ? element_rotations_ : start_rotations_, first);
  if (guarded_ > 0) --guarded_;
  double share = 1;
  for (int i = 0; i < kMaxTrials; ++i) {
    trial_x_ = x_ + share * step_;
    elastic_forces(model_, trial_x_, i == 0 ? element_rotations_ : trial_rotations_, trial_rotations_, elements_,
                   trial_forces_);
    const double end = merit_slope(share, descent_, resisting, step_, elastic_, trial_forces_);
    if (end <= descent_) break;
    share = cut_share(share, descent_, end);
  }
  if (share < 1) guarded_ = kGuardedTicks;
  return share;
}

double TissueMotion::move(double share) {
  assert(share > 0 && share <= 1);
  if (system_.empty()) return 0;
  first_ = {};
  if (iteration_ == 1 && !is(TissueMatrix::constant)) first_ = {share, descent_, elastic_.cwiseProduct(step_).sum()};
  x_ += share * step_;
  return share * step_.cwiseAbs().maxCoeff();
}

void TissueMotion::commit(TissueState& state) {
  state.guarded = guarded_;
  state.step = first_;
  state.inertia.setZero();
  state.moved = true;
  for (const int i : model_.free_nodes) {
    const Vector3 velocity = (x_.col(i) - state.x.col(i)) / system_.h;
    state.inertia += model_.mass[i] * (velocity - state.v.col(i)) / system_.h + model_.mass_damping[i] * velocity;
    velocity_.col(i) = velocity;
    state.v.col(i) = velocity;
    state.x.col(i) = x_.col(i);
  }
  for (const int i : model_.fixed_nodes) velocity_.col(i).setZero();
  state.support = -lambda_on_fixed_;
  if (system_.damped) {
    if (iteration_ > 1 || is(TissueMatrix::refactorized)) {
      damping_forces(model_, velocity_, iteration_ > 1 ? start_rotations_ : element_rotations_, elements_,
                     damping_force_);
      for (const int i : model_.fixed_nodes) state.support += damping_force_.col(i);
    } else {
      for (std::size_t k = 0; k < system_.beside_supports.size(); ++k)
        state.support -= system_.damping_sums[k] * velocity_.col(system_.beside_supports[k]);
    }
  }
  std::swap(state.rotations.batches, element_rotations_.batches);
}

}  // namespace acus
