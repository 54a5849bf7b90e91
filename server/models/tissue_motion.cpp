// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/models/tissue_motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace acus {

namespace {

// The free nodes of tetrahedra that have a fixed node.
std::vector<int> nodes_beside_supports(const TissueModel& model) {
  std::vector<bool> beside(static_cast<std::size_t>(model.nodes()));
  for (const auto& nodes : model.mesh->tetrahedra) {
    const auto is_fixed = [&](int node) { return model.free_index[node] < 0; };
    if (std::none_of(nodes.begin(), nodes.end(), is_fixed)) continue;
    for (const int node : nodes) beside[node] = beside[node] || !is_fixed(node);
  }
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

Eigen::Matrix<double, 3, 4> shape_gradients(const TetrahedralMesh& mesh, const Matrix3X& x, int tetrahedron) {
  const auto& nodes = mesh.tetrahedra[tetrahedron];
  const Vector3 a = x.col(nodes[1]) - x.col(nodes[0]), b = x.col(nodes[2]) - x.col(nodes[0]),
                c = x.col(nodes[3]) - x.col(nodes[0]);
  const double six_volume = a.dot(b.cross(c));
  Eigen::Matrix<double, 3, 4> gradients = Eigen::Matrix<double, 3, 4>::Zero();
  if (!(std::abs(six_volume) > 1e-12 * a.norm() * b.norm() * c.norm())) return gradients;  // flat: nothing to turn
  gradients.col(1) = b.cross(c) / six_volume;
  gradients.col(2) = c.cross(a) / six_volume;
  gradients.col(3) = a.cross(b) / six_volume;
  gradients.col(0) = -(gradients.col(1) + gradients.col(2) + gradients.col(3));
  return gradients;
}

Vector3 material_rotation(const TetrahedralMesh& mesh, const Matrix3X& from, const Matrix3X& x, int tetrahedron) {
  const auto gradients = shape_gradients(mesh, x, tetrahedron);
  Vector3 sum = Vector3::Zero();
  for (int k = 0; k < 4; ++k) {
    const int node = mesh.tetrahedra[tetrahedron][k];
    sum += gradients.col(k).cross(Vector3(x.col(node) - from.col(node)));
  }
  return sum / 2;
}

TissueMotion::TissueMotion(const TissueModel& model, double h, TissueMatrix matrix, int max_rows, int max_nodes)
    : model_(model), h_(h), matrix_(matrix), damped_(has_stiffness_damping(model)), assembler_(model) {
  element_rotations_.reset(model);
  start_rotations_ = element_rotations_;
  x_ = model.mesh->nodes;
  elastic_.setZero(3, model.nodes());
  rotations_.setZero(4, model.nodes());
  y_.setZero(model.unknowns());
  velocity_.setZero(3, model.nodes());
  damping_force_ = velocity_;
  rows_.resize(static_cast<std::size_t>(max_rows));
  weight_.setZero();
  for (int i : model.free_nodes) weight_ += model.mass[i] * model.gravity;
  if (!empty()) {
    factorize_rest();
    for (int f = 0; f < static_cast<int>(model.free_nodes.size()); ++f) position_.push_back(factor_.position(3 * f));
    corridor_.emplace(factor_, std::min(max_nodes, static_cast<int>(model.free_nodes.size())));
    const int slots = corridor_->capacity();
    gram_rows_.setZero(3 * slots, max_rows);
    gram_columns_.setZero(max_rows, 3 * slots);
    slot_displacement_.setZero(3, slots);
    slot_read_.resize(static_cast<std::size_t>(slots));
    slot_forces_.setZero(3 * slots);
  }
  if (matrix == TissueMatrix::constant) stiffness_.emplace(model);
  reset();
}

void TissueMotion::factorize_rest() {
  SparseMatrix rest;
  const Matrix3X& nodes = model_.mesh->nodes;
  assembler_.assemble(nodes, element_rotations_, Tangent::rest, {1 / (h_ * h_), 1 / h_, 1, 1 / h_}, rest);
  factor_.analyze(rest, 3);
  const auto factorize = [&](Precision precision) {
    if (!factor_.factorize(rest, precision)) throw std::runtime_error("the tissue's matrix is not positive definite");
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

void TissueMotion::reset() {
  restart();
  if (corridor_) corridor_->clear();
}

void TissueMotion::restart() {
  element_rotations_.reset(model_);
  rotations_.setZero();
  rotations_.row(0).setOnes();
  pending_support_.setZero();
  pending_ = balance_ = Balance{};
}

void TissueMotion::begin(const TissueState& state) {
  x_ = state.x;
  iteration_ = 0;
  if (corridor_) corridor_->begin_use();
}

// Elastic forces at x_k; on the first call of a tick also what the last tick's supports carried.
void TissueMotion::evaluate() {
  if (matrix_ == TissueMatrix::constant) {
    stiffness_->forces(x_, elastic_);
  } else {
    elastic_forces(model_, x_, element_rotations_, elastic_);
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
    corridor_->clear();
  }
  ++iteration_;
  factor_.forward(y_);
  return exact;
}

void TissueMotion::clear_rows() { row_count_ = 0; }

TissueMotion::Row& TissueMotion::begin_row() {
  assert(row_count_ < static_cast<int>(rows_.size()));
  Row& row = rows_[row_count_];
  row.parts = 0;
  row.on_fixed.setZero();
  return row;
}

bool TissueMotion::add_node(Row& row, int node, const Vector3& force) {
  const int free = model_.free_index[node];
  if (free < 0) {
    row.on_fixed += force;
    return true;
  }
  const int slot = corridor_->slot(free);
  if (slot < 0) return false;
  row.slot[row.parts] = slot;
  row.force[row.parts++] = to_factor(node, force);
  return true;
}

bool TissueMotion::add_part(Row& row, const MaterialPoint& point, const Vector3& force) {
  const auto& nodes = model_.mesh->tetrahedra[point.tetrahedron];
  for (int k = 0; k < 4; ++k)
    if (!add_node(row, nodes[k], point.weights[k] * force)) return false;
  return true;
}

int TissueMotion::add_row(const TissuePoint& point, const Vector3& force) {
  Row& row = begin_row();
  if (!add_part(row, point.a, (1 - point.u) * force)) return -1;
  if (point.u > 0 && !add_part(row, point.b, point.u * force)) return -1;
  return row_count_++;
}

int TissueMotion::add_couple(int tetrahedron, const Vector3& torque) {
  Row& row = begin_row();
  const auto gradients = shape_gradients(*model_.mesh, x_, tetrahedron);
  for (int k = 0; k < 4; ++k)
    if (!add_node(row, model_.mesh->tetrahedra[tetrahedron][k], 0.5 * torque.cross(gradients.col(k)))) return -1;
  return row_count_++;
}

int TissueMotion::add_empty_row() {
  begin_row();
  return row_count_++;
}

// W_t = Sᵀ G S and delta = Sᵀ Yᵀ y, S the rows' forces on the slots. G S first, by rows; turned round, so that all rows
// that come after one are contiguous, W_t takes one pass over them for each of the few slots that the row acts on. Slots
// before the first and behind the last that a row acts on are left alone: what other paths have left behind.
void TissueMotion::add_compliance(Eigen::Ref<MatrixX> W, std::span<double> delta) {
  if (empty()) return;
  const int n = row_count_;
  int first = corridor_->used(), last = -1;
  for (int r = 0; r < n; ++r)
    for (int k = 0; k < rows_[r].parts; ++k) {
      first = std::min(first, rows_[r].slot[k]);
      last = std::max(last, rows_[r].slot[k]);
    }
  if (last < 0) return;
  const int dofs = 3 * (last - first + 1);
  std::fill(slot_read_.begin() + first, slot_read_.begin() + last + 1, 0);
  for (int r = 0; r < n; ++r) {
    const Row& row = rows_[r];
    auto column = gram_rows_.col(r).head(dofs);
    column.setZero();
    for (int k = 0; k < row.parts; ++k) {
      const int slot = row.slot[k];
      const Vector3& f = row.force[k];
      const auto gram = corridor_->gram().block(3 * first, 3 * slot, dofs, 3);
      column += f[0] * gram.col(0) + f[1] * gram.col(1) + f[2] * gram.col(2);
      if (std::exchange(slot_read_[slot], 1) == 0) slot_displacement_.col(slot) = corridor_->free_displacement(slot, y_);
      delta[r] += f.dot(slot_displacement_.col(slot));
    }
  }
  gram_columns_.topLeftCorner(n, dofs) = gram_rows_.topLeftCorner(dofs, n).transpose();
  for (int r = 0; r < n; ++r) {
    auto below = W.col(r).segment(r, n - r);
    for (int k = 0; k < rows_[r].parts; ++k) {
      const Vector3& f = rows_[r].force[k];
      const auto columns = gram_columns_.block(r, 3 * (rows_[r].slot[k] - first), n - r, 3);
      below += f[0] * columns.col(0) + f[1] * columns.col(1) + f[2] * columns.col(2);
    }
  }
}

bool TissueMotion::prepare(int tetrahedron) {
  if (matrix_ == TissueMatrix::refactorized) return false;
  for (const int node : model_.mesh->tetrahedra[tetrahedron]) {
    const int free = model_.free_index[node];
    if (free < 0) continue;
    const bool made = !corridor_->holds(free);
    if (corridor_->slot(free) < 0) return false;
    if (made) return true;
  }
  return false;
}

double TissueMotion::correct(std::span<const double> lambda) {
  lambda_on_fixed_.setZero();
  if (empty()) return 0;
  slot_forces_.setZero();
  for (int r = 0; r < row_count_; ++r) {
    for (int k = 0; k < rows_[r].parts; ++k)
      slot_forces_.segment<3>(3 * rows_[r].slot[k]) += lambda[r] * rows_[r].force[k];
    lambda_on_fixed_ += lambda[r] * rows_[r].on_fixed;
  }
  for (int s = 0; s < corridor_->used(); ++s) {
    const Vector3 force = slot_forces_.segment<3>(3 * s);
    if (!force.isZero(0)) corridor_->add_force(s, force, y_);
  }
  factor_.backward(y_);

  double largest = 0;
  for (int f = 0; f < static_cast<int>(position_.size()); ++f) {
    const int i = model_.free_nodes[f];
    const Vector3 step = matrix_ == TissueMatrix::turned ? Vector3(rotation(i) * in_factor(f)) : Vector3(in_factor(f));
    x_.col(i) += step;
    largest = std::max(largest, step.cwiseAbs().maxCoeff());
  }
  return largest;
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
