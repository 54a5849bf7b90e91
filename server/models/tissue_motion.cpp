// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/models/tissue_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "server/math/step_share.h"

namespace acus {

namespace {

// The free nodes of tetrahedra and patches that have a fixed node.
std::vector<int> nodes_beside_supports(const TissueModel& model) {
  std::vector<bool> beside(static_cast<std::size_t>(model.nodes()));
  const auto mark = [&](std::span<const int> nodes) {
    const auto is_fixed = [&](int node) { return model.free_index[node] < 0; };
    if (std::none_of(nodes.begin(), nodes.end(), is_fixed)) return;
    for (const int node : nodes) beside[node] = beside[node] || !is_fixed(node);
  };
  for (const auto& nodes : model.mesh->tetrahedra) mark(nodes);
  for (int patch = 0; patch < model.pressure.patches(); ++patch) mark(model.pressure.nodes_of(patch));
  std::vector<int> list;
  for (const int node : model.free_nodes)
    if (beside[node]) list.push_back(node);
  return list;
}

// Sum of all rows of beta K0 restricted to free unknowns, three rows: the damping force that the free nodes receive in
// total is this times their velocity, and the supports take the opposite. Zero but beside supports, since no element
// answers a translation.
Matrix3X stiffness_damping_sums(const SparseMatrix& lower) {
  Matrix3X sums = Matrix3X::Zero(3, lower.cols());
  for (int column = 0; column < lower.outerSize(); ++column)
    for (SparseMatrix::InnerIterator it(lower, column); it; ++it) {
      sums(it.row() % 3, column) += it.value();
      if (it.row() != column) sums(column % 3, it.row()) += it.value();
    }
  return sums;
}

bool has_stiffness_damping(const TissueModel& model) {
  return std::any_of(model.rayleigh_stiffness.begin(), model.rayleigh_stiffness.end(), [](double b) { return b > 0; });
}

// The edge of a cube of six tetrahedra of mean volume (m); none in a model without elements.
double mean_element_size(const TissueModel& model) {
  double volume = 0;
  for (const TetrahedronShape<double>& element : model.elements) volume += element.volume;
  return model.elements.empty() ? 0 : std::cbrt(6 * volume / static_cast<double>(model.elements.size()));
}

// How far L Lᵀ is from A: the largest relative error of A⁻¹ A z for displacements z, the three translations and one
// that differs from node to node.
double factor_error(const SparseCholesky& factor, const SparseMatrix& lower) {
  double largest = 0;
  VectorX z(lower.cols()), solution(lower.cols());
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < z.size(); ++i) z[i] = k == 3 ? std::sin(1.0 + i) : i % 3 == k ? 1 : 0;
    const VectorX force = lower.selfadjointView<Eigen::Lower>() * z;
    for (int i = 0; i < z.size(); ++i) solution[factor.position(i)] = force[i];
    factor.forward(solution);
    factor.backward(solution);
    for (int i = 0; i < z.size(); ++i) {
      const double error = std::abs(solution[factor.position(i)] - z[i]);
      if (!(error <= largest)) largest = error;  // not-a-number is the largest of all
    }
  }
  return largest;
}

}  // namespace

TissueMotion::TissueMotion(const TissueModel& model, double h, TissueMatrix matrix, int max_rows, int max_nodes)
    : model_(model), h_(h), matrix_(matrix), damped_(has_stiffness_damping(model)), assembler_(model) {
  element_rotations_.reset(model);
  start_rotations_ = trial_rotations_ = element_rotations_;
  x_ = trial_x_ = model.mesh->nodes;
  elastic_.setZero(3, model.nodes());
  step_ = trial_forces_ = elastic_;
  large_step_ = kLargeStep * mean_element_size(model);
  for (const double beta : model.rayleigh_stiffness) largest_damping_ = std::max(largest_damping_, beta);
  rotations_.setZero(4, model.nodes());
  y_.setZero(model.unknowns());
  velocity_.setZero(3, model.nodes());
  damping_force_ = velocity_;
  on_fixed_.resize(static_cast<std::size_t>(max_rows));
  weight_.setZero();
  for (int i : model.free_nodes) weight_ += model.mass[i] * model.gravity;
  if (!empty()) {
    factorize_rest();
    for (int f = 0; f < static_cast<int>(model.free_nodes.size()); ++f) position_.push_back(factor_.position(3 * f));
  }
  rows_.emplace(factor_, max_rows, max_nodes);
  if (matrix == TissueMatrix::constant) stiffness_.emplace(model);
  reset();
}

void TissueMotion::factorize_rest() {
  SparseMatrix rest;
  const Matrix3X& nodes = model_.mesh->nodes;
  assembler_.assemble(nodes, element_rotations_, Tangent::rest, tick_factors(h_), rest);
  factor_.analyze(rest, 3);
  const auto factorize = [&](Precision precision) {
    if (!factor_.factorize(rest, precision)) {
      throw std::runtime_error(
          "tissue: expected a stiffness that can be factorised, found a matrix that is not positive definite; bring "
          "young_modulus and density of its regions closer together, or poisson_ratio further from 0.5");
    }
  };
  if (matrix_ == TissueMatrix::refactorized) return factorize(Precision::double_precision);
  factorize(Precision::single_precision);
  if (!(factor_error(factor_, rest) < kSinglePrecisionError)) factorize(Precision::double_precision);
  factor_.finish();
  if (!damped_) return;
  assembler_.assemble(nodes, element_rotations_, Tangent::rest, {.stiffness_damping = 1}, rest);
  beside_supports_ = nodes_beside_supports(model_);
  const Matrix3X sums = stiffness_damping_sums(rest);
  for (const int node : beside_supports_) damping_sums_.push_back(sums.middleCols<3>(3 * model_.free_index[node]));
}

double TissueMotion::elastic_energy(const Matrix3X& x) {
  if (!stiffness_) return acus::elastic_energy(model_, x, element_rotations_);
  Matrix3X forces(3, x.cols());
  stiffness_->forces(x, forces);
  return forces.cwiseProduct(x - model_.mesh->nodes).sum() / 2;
}

void TissueMotion::reset() {
  restart();
  rows_->corridor().clear();
}

void TissueMotion::restart() {
  element_rotations_.reset(model_);
  rotations_.setZero();
  rotations_.row(0).setOnes();
  pending_support_.setZero();
  pending_ = balance_ = Balance{};
  share_ = 0;
  guarded_ = 0;
}

void TissueMotion::begin(const TissueState& state) {
  x_ = state.x;
  iteration_ = 0;
  inverted_ = false;
  rows_->corridor().begin_use();
}

// Elastic forces at x_k; on the first call of a tick also what the last tick's supports carried.
void TissueMotion::evaluate() {
  if (matrix_ == TissueMatrix::constant) {
    stiffness_->forces(x_, elastic_);
  } else {
    elastic_.swap(trial_forces_);
    elastic_forces(model_, x_, element_rotations_, elastic_);
    if (share_ > 0 && overshot()) guarded_ = kGuardedTicks;
    share_ = 0;
    inverted_ = inverted_ || element_rotations_.inverted;
  }
  if (matrix_ == TissueMatrix::turned) node_rotations(model_, element_rotations_, rotations_);
  if (iteration_ > 0) return;
  balance_ = pending_;
  balance_.support = pending_support_;
  for (int i : model_.fixed_nodes) balance_.support += elastic_.col(i);
}

bool TissueMotion::refactorize() {
  // The Hessian at x_k; where it is indefinite, the turned rest stiffness, which never is.
  for (const Tangent tangent : {Tangent::exact, Tangent::turned}) {
    assembler_.assemble(x_, element_rotations_, tangent, {1 / (h_ * h_), 1 / h_, 1, 0}, system_);
    if (damped_)
      Eigen::Map<VectorX>(system_.valuePtr(), system_.nonZeros()) +=
          Eigen::Map<const VectorX>(damping_.valuePtr(), damping_.nonZeros()) / h_;
    if (factor_.factorize(system_)) return tangent == Tangent::exact;
  }
  return false;
}

// -g at x_k into y, in the factor's frame and order.
void TissueMotion::put_residual(const TissueState& state) {
  for (int f = 0; f < static_cast<int>(position_.size()); ++f) {
    const int i = model_.free_nodes[f];
    Vector3 residual = model_.mass[i] * (model_.gravity + state.v.col(i) / h_) - elastic_.col(i);
    if (iteration_ > 0) {  // on the first, x_k = x_n
      const Vector3 velocity = (x_.col(i) - state.x.col(i)) / h_;
      residual -= (model_.mass[i] / h_ + model_.mass_damping[i]) * velocity + damping_force_.col(i);
    }
    in_factor(f) = to_factor(i, residual);
  }
}

// The damping of the stiffness, beta R K0 Rᵀ (x_k - x_n)/h with R of the start of the tick.
void TissueMotion::evaluate_damping(const TissueState& state) {
  velocity_ = (x_ - state.x) / h_;
  damping_forces(model_, velocity_, start_rotations_, damping_force_);
}

bool TissueMotion::linearize(const TissueState& state) {
  if (empty()) return true;
  if (iteration_ == 1) start_rotations_.batches = element_rotations_.batches;
  evaluate();
  if (damped_ && iteration_ > 0) evaluate_damping(state);
  put_residual(state);
  bool exact = true;
  if (matrix_ == TissueMatrix::refactorized) {
    if (damped_ && iteration_ == 0)
      assembler_.assemble(x_, element_rotations_, Tangent::turned, {.stiffness_damping = 1}, damping_);
    exact = refactorize();
    rows_->corridor().clear();
  }
  ++iteration_;
  factor_.forward(y_);
  return exact;
}

void TissueMotion::clear_rows() { rows_->clear(); }

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
    if (!add_node(nodes[k], point.weights[k] * force)) return false;
  return true;
}

int TissueMotion::add_row(const TissuePoint& point, const Vector3& force) {
  begin_row();
  if (!add_part(point.a, (1 - point.u) * force)) return -1;
  if (point.u > 0 && !add_part(point.b, point.u * force)) return -1;
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

void TissueMotion::add_compliance(Eigen::Ref<MatrixX> W, std::span<double> delta) {
  rows_->add_compliance(y_, W, delta);
}

bool TissueMotion::prepare(int tetrahedron) {
  if (matrix_ == TissueMatrix::refactorized) return false;
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
  if (empty()) return;
  for (int r = 0; r < rows_->count(); ++r) lambda_on_fixed_ += lambda[r] * on_fixed_[r];
  rows_->add_forces(lambda, y_);
  last_descent_ = iteration_ > 1 ? descent_ : std::numeric_limits<double>::infinity();
  descent_ = y_.squaredNorm();
  factor_.backward(y_);
  for (int f = 0; f < static_cast<int>(position_.size()); ++f) {
    const int i = model_.free_nodes[f];
    step_.col(i) = matrix_ == TissueMatrix::turned ? Vector3(rotation(i) * in_factor(f)) : Vector3(in_factor(f));
  }
}

// Of the merit at the end of a share of the step, where the elastic forces are `forces`; those at its start are kept in
// the other of elastic_ and trial_forces_.
double TissueMotion::slope(double share, const Matrix3X& forces) const {
  const Matrix3X& before = &forces == &elastic_ ? trial_forces_ : elastic_;
  return -descent_ + share * resistance_ + (forces - before).cwiseProduct(step_).sum();
}

// dxᵀ (M/h² + B/h) dx of the step.
double TissueMotion::resistance(bool first) {
  double inertia = 0;
  for (const int i : model_.free_nodes)
    inertia += (model_.mass[i] / h_ + model_.mass_damping[i]) / h_ * step_.col(i).squaredNorm();
  if (!damped_) return inertia;
  if (matrix_ == TissueMatrix::turned && first) return descent_ - (descent_ - inertia) / (1 + largest_damping_ / h_);
  damping_forces(model_, step_, first ? element_rotations_ : start_rotations_, damping_force_);
  return inertia + damping_force_.cwiseProduct(step_).sum() / h_;
}

// Whether the end of a tick's first step, where the elastic forces are known by now, was too steep. Since the
// resistance is at most d, mostly the elastic forces alone say that it was not.
bool TissueMotion::overshot() {
  if ((elastic_ - trial_forces_).cwiseProduct(step_).sum() <= descent_) return false;
  resistance_ = resistance(true);
  return !(slope(share_, elastic_) <= descent_);
}

double TissueMotion::trusted_share() {
  if (empty() || matrix_ == TissueMatrix::constant) return 1;
  const bool far = !(step_.cwiseAbs().maxCoeff() <= large_step_), longer = !(descent_ <= last_descent_);
  const bool looked_at = guarded_ > 0 || far || longer;
  if (!looked_at) return 1;
  resistance_ = resistance(iteration_ == 1);
  if (guarded_ > 0) --guarded_;
  trial_rotations_.batches = element_rotations_.batches;
  double share = 1;
  for (int i = 0; i < kMaxTrials; ++i) {
    trial_x_ = x_ + share * step_;
    elastic_forces(model_, trial_x_, trial_rotations_, trial_forces_);
    const double end = slope(share, trial_forces_);
    if (end <= descent_) break;
    share = cut_share(share, descent_, end);
  }
  if (share < 1) guarded_ = kGuardedTicks;
  return share;
}

double TissueMotion::move(double share) {
  if (empty()) return 0;
  share_ = iteration_ == 1 ? share : 0;
  x_ += share * step_;
  return share * step_.cwiseAbs().maxCoeff();
}

void TissueMotion::commit(TissueState& state) {
  pending_ = Balance{};
  pending_.weight = weight_;
  for (int f = 0; f < static_cast<int>(position_.size()); ++f) {
    const int i = model_.free_nodes[f];
    const Vector3 velocity = (x_.col(i) - state.x.col(i)) / h_;
    pending_.inertia += model_.mass[i] * (velocity - state.v.col(i)) / h_ + model_.mass_damping[i] * velocity;
    velocity_.col(i) = velocity;
    state.v.col(i) = velocity;
    state.x.col(i) = x_.col(i);
  }
  pending_support_ = -lambda_on_fixed_;
  if (!damped_) return;
  if (iteration_ > 1 || matrix_ == TissueMatrix::refactorized) {
    damping_forces(model_, velocity_, iteration_ > 1 ? start_rotations_ : element_rotations_, damping_force_);
    for (int i : model_.fixed_nodes) pending_support_ += damping_force_.col(i);
  } else {
    for (std::size_t k = 0; k < beside_supports_.size(); ++k)
      pending_support_ -= damping_sums_[k] * velocity_.col(beside_supports_[k]);
  }
}

}  // namespace acus
