// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/models/tissue_motion.h"

#include <algorithm>
#include <cassert>
#include <stdexcept>

namespace acus {

namespace {

// Sum of all rows of beta K0 restricted to free unknowns, three rows: the damping force that the free nodes receive in
// total is this times their velocity, and the supports take the opposite.
Eigen::Matrix3Xd stiffness_damping_sums(const SparseMatrix& lower) {
  Eigen::Matrix3Xd sums = Eigen::Matrix3Xd::Zero(3, lower.cols());
  for (int column = 0; column < lower.outerSize(); ++column)
    for (SparseMatrix::InnerIterator it(lower, column); it; ++it) {
      sums(it.row() % 3, column) += it.value();
      if (it.row() != column) sums(column % 3, it.row()) += it.value();
    }
  return sums;
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
    : model_(model),
      h_(h),
      matrix_(matrix),
      assembler_(model),
      corridor_(static_cast<int>(model.free_nodes.size()), std::min(max_nodes, static_cast<int>(model.free_nodes.size()))) {
  element_rotations_.reset(model);
  SparseMatrix rest;
  assembler_.assemble(model.mesh->nodes, element_rotations_, Tangent::rest, {1 / (h * h), 1 / h, 1, 1 / h}, rest);
  factor_.analyze(rest);
  if (!factor_.factorize(rest)) throw std::runtime_error("the tissue's matrix is not positive definite");
  if (matrix == TissueMatrix::fixed) {
    assembler_.assemble(model.mesh->nodes, element_rotations_, Tangent::rest, {.stiffness_damping = 1}, rest);
    damping_sums_ = stiffness_damping_sums(rest);
  }

  x_ = model.mesh->nodes;
  elastic_.setZero(3, model.nodes());
  residual_ = elastic_;
  rotations_.setZero(4, model.nodes());
  y_.setZero(model.unknowns());
  unknowns_ = y_;
  rows_.resize(static_cast<std::size_t>(max_rows));
  gram_rows_.setZero(3 * corridor_.capacity(), max_rows);
  slot_forces_.setZero(3 * corridor_.capacity());
  reset();
}

void TissueMotion::reset() {
  element_rotations_.reset(model_);
  rotations_.setZero();
  rotations_.row(0).setOnes();
  corridor_.clear();
  pending_support_.setZero();
  pending_ = balance_ = Balance{};
}

void TissueMotion::begin(const TissueState& state) {
  x_ = state.x;
  first_iteration_ = true;
  corridor_.begin_use();
}

// Elastic forces at x_k and the residual -g; on the first call of a tick also what the last tick's supports carried.
void TissueMotion::evaluate(const TissueState& state) {
  elastic_forces(model_, x_, element_rotations_, elastic_);
  if (first_iteration_) {
    balance_ = pending_;
    balance_.support = pending_support_;
    for (int i = 0; i < model_.nodes(); ++i)
      if (model_.free_index[i] < 0) balance_.support += elastic_.col(i);
  }
  for (int i : model_.free_nodes) {
    const Vector3 velocity = (x_.col(i) - state.x.col(i)) / h_;
    residual_.col(i) = model_.mass[i] * (model_.gravity - (velocity - state.v.col(i)) / h_) -
                       model_.mass_damping[i] * velocity - elastic_.col(i);
  }
}

bool TissueMotion::refactorize() {
  // The Hessian at x_k; where it is indefinite, the turned rest stiffness, which never is.
  for (const Tangent tangent : {Tangent::exact, Tangent::turned}) {
    assembler_.assemble(x_, element_rotations_, tangent, {1 / (h_ * h_), 1 / h_, 1, 0}, system_);
    Eigen::Map<VectorX>(system_.valuePtr(), system_.nonZeros()) +=
        Eigen::Map<const VectorX>(damping_.valuePtr(), damping_.nonZeros()) / h_;
    if (factor_.factorize(system_)) return tangent == Tangent::exact;
  }
  return false;
}

void TissueMotion::turn_to_rest(Matrix3X& vectors) const {
  for (int i : model_.free_nodes) vectors.col(i) = rotation(i).conjugate() * vectors.col(i);
}

bool TissueMotion::linearize(const TissueState& state) {
  evaluate(state);
  bool exact = true;
  if (matrix_ == TissueMatrix::fixed) {
    node_rotations(model_, element_rotations_, rotations_);
    turn_to_rest(residual_);
  } else {
    if (first_iteration_) {
      assembler_.assemble(x_, element_rotations_, Tangent::turned, {.stiffness_damping = 1}, damping_);
    } else {
      for (int i : model_.free_nodes)
        unknowns_.segment<3>(3 * model_.free_index[i]) = (x_.col(i) - state.x.col(i)) / h_;
      const VectorX force = damping_.selfadjointView<Eigen::Lower>() * unknowns_;
      for (int i : model_.free_nodes) residual_.col(i) -= force.segment<3>(3 * model_.free_index[i]);
    }
    exact = refactorize();
    corridor_.clear();
  }
  first_iteration_ = false;

  for (int i : model_.free_nodes)
    for (int k = 0; k < 3; ++k) y_[factor_.position(3 * model_.free_index[i] + k)] = residual_(k, i);
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
  const int slot = corridor_.slot(factor_, free);
  if (slot < 0) return false;
  row.slot[row.parts] = slot;
  row.force[row.parts++] = rotation(node).conjugate() * force;
  return true;
}

bool TissueMotion::add_part(Row& row, const MaterialPoint& point, const Vector3& force) {
  const auto& nodes = model_.mesh->tetrahedra[point.tetrahedron];
  for (int k = 0; k < 4; ++k)
    if (!add_node(row, nodes[k], point.weights[k] * force)) return false;
  return true;
}

int TissueMotion::finish_row(const Row& row) {
  auto column = gram_rows_.col(row_count_).head(3 * corridor_.used());
  column.setZero();
  for (int k = 0; k < row.parts; ++k)
    for (int i = 0; i < 3; ++i)
      column += row.force[k][i] * corridor_.gram().col(3 * row.slot[k] + i).head(3 * corridor_.used());
  return row_count_++;
}

int TissueMotion::add_row(const TissuePoint& point, const Vector3& force) {
  Row& row = begin_row();
  if (!add_part(row, point.a, (1 - point.u) * force)) return -1;
  if (point.u > 0 && !add_part(row, point.b, point.u * force)) return -1;
  return finish_row(row);
}

int TissueMotion::add_couple(int tetrahedron, const Vector3& torque) {
  Row& row = begin_row();
  const auto gradients = shape_gradients(*model_.mesh, x_, tetrahedron);
  for (int k = 0; k < 4; ++k)
    if (!add_node(row, model_.mesh->tetrahedra[tetrahedron][k], 0.5 * torque.cross(gradients.col(k)))) return -1;
  return finish_row(row);
}

int TissueMotion::add_empty_row() { return finish_row(begin_row()); }

double TissueMotion::compliance(int a, int b) const {
  // A column knows the slots that existed when its row was added, so the later row's column serves both.
  const Row& row = rows_[std::min(a, b)];
  const auto column = gram_rows_.col(std::max(a, b));
  double sum = 0;
  for (int k = 0; k < row.parts; ++k) sum += row.force[k].dot(column.segment<3>(3 * row.slot[k]));
  return sum;
}

double TissueMotion::free_displacement(int r) const {
  const Row& row = rows_[r];
  double sum = 0;
  for (int k = 0; k < row.parts; ++k) sum += row.force[k].dot(corridor_.free_displacement(row.slot[k], y_));
  return sum;
}

double TissueMotion::correct(std::span<const double> lambda) {
  slot_forces_.setZero();
  lambda_on_fixed_.setZero();
  for (int r = 0; r < row_count_; ++r) {
    for (int k = 0; k < rows_[r].parts; ++k)
      slot_forces_.segment<3>(3 * rows_[r].slot[k]) += lambda[r] * rows_[r].force[k];
    lambda_on_fixed_ += lambda[r] * rows_[r].on_fixed;
  }
  for (int s = 0; s < corridor_.used(); ++s) {
    const Vector3 force = slot_forces_.segment<3>(3 * s);
    if (!force.isZero(0)) corridor_.add_force(s, force, y_);
  }
  factor_.backward(y_);

  double largest = 0;
  for (int i : model_.free_nodes) {
    const int unknown = 3 * model_.free_index[i];
    const Vector3 rest(y_[factor_.position(unknown)], y_[factor_.position(unknown + 1)],
                       y_[factor_.position(unknown + 2)]);
    const Vector3 step = matrix_ == TissueMatrix::fixed ? rotation(i) * rest : rest;
    x_.col(i) += step;
    largest = std::max(largest, step.cwiseAbs().maxCoeff());
  }
  return largest;
}

void TissueMotion::commit(TissueState& state) {
  pending_ = Balance{};
  for (int i : model_.free_nodes) {
    const Vector3 velocity = (x_.col(i) - state.x.col(i)) / h_;
    pending_.weight += model_.mass[i] * model_.gravity;
    pending_.inertia += model_.mass[i] * (velocity - state.v.col(i)) / h_ + model_.mass_damping[i] * velocity;
    unknowns_.segment<3>(3 * model_.free_index[i]) = velocity;
    state.v.col(i) = velocity;
  }
  if (matrix_ == TissueMatrix::fixed) {
    pending_support_ = -damping_sums_ * unknowns_;
  } else {
    const VectorX force = damping_.selfadjointView<Eigen::Lower>() * unknowns_;
    pending_support_ = -Eigen::Map<const Matrix3X>(force.data(), 3, force.size() / 3).rowwise().sum();
  }
  pending_support_ -= lambda_on_fixed_;
  state.x = x_;
}

}  // namespace acus
