// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle_motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "server/engine/math/rotation.h"
#include "server/engine/math/step_share.h"

namespace acus {

NeedleMotion::NeedleMotion(const NeedleModel& model, double h, int max_rows)
    : model_(model), h_(h), compliance_(model.beams, max_rows) {
  const auto nodes = static_cast<std::size_t>(model.nodes());
  iterate_.shape.x.setZero(3, model.nodes());
  iterate_.shape.frames.assign(nodes, Matrix3::Identity());
  iterate_.q.assign(nodes, Quaternion::Identity());
  rigid_ = trial_ = iterate_;
  material_.assign(static_cast<std::size_t>(model.beams), Matrix12::Zero());
  g_.setZero(6, model.nodes());
  trial_g_ = g_;
  const int free_nodes = model.rigid ? 0 : model.beams;
  if (free_nodes > 0) matrix_.resize(free_nodes);
  dq_free_.setZero(6 * free_nodes);
  dq_ = applied_ = dq_free_;
  rows_.reserve(static_cast<std::size_t>(max_rows));
  if (!model.hold) return;
  held_.emplace(*model.hold, h);
  follow_.setZero(6 * free_nodes, 6);
  base_rows_.setZero(max_rows, 6);
}

void NeedleMotion::begin(const NeedleState& state, const Pose& commanded, const Pose& before) {
  if (held_) held_->begin(before, commanded, {state.x.col(0), state.q[0]});
  const Pose base = held_ ? held_->carried_along() : commanded;
  const Quaternion turn = base.orientation * state.q[0].conjugate();
  const Vector3 pivot = state.x.col(0);
  for (int i = 0; i < model_.nodes(); ++i) {
    iterate_.shape.x.col(i) = base.position + turn * (state.x.col(i) - pivot);
    iterate_.q[i] = (turn * state.q[i]).normalized();
    iterate_.shape.frames[i] = iterate_.q[i].toRotationMatrix();
  }
  rigid_ = iterate_;
  at_rigid_ = true;
  if (model_.rayleigh_stiffness == 0 || model_.rigid) return;
  for (int e = 0; e < model_.beams; ++e) {
    const NeedleBeam beam = needle_beam(model_, rigid_.shape, e);
    material_[e] = beam_material_tangent(beam.stiffness, beam.a, beam.b);
  }
}

// A beam's turn from q_0 to q, the mean of its nodes'.
Matrix3 NeedleMotion::beam_turn(const Configuration& at, int e) const {
  const Vector3 first = rotation_log(at.q[e] * rigid_.q[e].conjugate());
  const Vector3 second = rotation_log(at.q[e + 1] * rigid_.q[e + 1].conjugate());
  return rotation_exp((first + second) / 2).toRotationMatrix();
}

// beta K_m (q - q_0)/h of a beam, K_m turned along. The turn is no part of what is damped: a needle that does not
// follow its base's spin is not pushed by it.
Vector12 NeedleMotion::beam_damping_force(const Configuration& at, int e, const Matrix12& turned_material) const {
  const Matrix3 turn = beam_turn(at, e);
  const Matrix3X &x = at.shape.x, &x_rigid = rigid_.shape.x;
  const Vector3 stretch = x.col(e + 1) - x.col(e) - turn * (x_rigid.col(e + 1) - x_rigid.col(e));
  const Quaternion back(turn.transpose());
  Vector12 moved;
  moved << -stretch / 2, rotation_log(at.q[e] * (back.conjugate() * rigid_.q[e]).conjugate()), stretch / 2,
      rotation_log(at.q[e + 1] * (back.conjugate() * rigid_.q[e + 1]).conjugate());
  return model_.rayleigh_stiffness / h_ * turned_material * moved;
}

// K_m of a beam, turned from q_0 to a configuration.
Matrix12 NeedleMotion::turned_material(const Configuration& at, int e) const {
  const Matrix3 turn = beam_turn(at, e);
  Matrix12 turned;
  for (int i = 0; i < 12; i += 3)
    for (int j = 0; j < 12; j += 3) turned.block<3, 3>(i, j) = turn * material_[e].block<3, 3>(i, j) * turn.transpose();
  return turned;
}

void NeedleMotion::add_beams(bool exact) {
  const double damping = model_.rayleigh_stiffness / h_;
  for (int e = 0; e < model_.beams; ++e) {
    const auto [stiffness, a, b] = needle_beam(model_, iterate_.shape, e);
    Vector12 force = beam_forces(stiffness, a, b);
    Matrix12 tangent = exact ? beam_tangent(stiffness, a, b) : beam_material_tangent(stiffness, a, b);
    if (damping > 0) {
      const Matrix12 material = at_rigid_ ? material_[e] : turned_material(iterate_, e);
      tangent += damping * material;
      if (!at_rigid_) force += beam_damping_force(iterate_, e, material);
    }
    g_.col(e) += force.head<6>();
    g_.col(e + 1) += force.tail<6>();
    matrix_.diagonal[e] += tangent.bottomRightCorner<6, 6>();
    if (e > 0) {
      matrix_.diagonal[e - 1] += tangent.topLeftCorner<6, 6>();
      matrix_.lower[e - 1] = tangent.bottomLeftCorner<6, 6>();
    } else {
      base_coupling_ = tangent.topRightCorner<6, 6>();
      base_diagonal_ = tangent.topLeftCorner<6, 6>();
    }
  }
}

// g at a configuration other than q_0.
void NeedleMotion::put_residual(const NeedleState& state, const Configuration& at, Matrix6X& g) const {
  g.setZero();
  for (int e = 0; e < model_.beams; ++e) {
    const auto [stiffness, a, b] = needle_beam(model_, at.shape, e);
    Vector12 force = beam_forces(stiffness, a, b);
    if (model_.rayleigh_stiffness > 0) force += beam_damping_force(at, e, turned_material(at, e));
    g.col(e) += force.head<6>();
    g.col(e + 1) += force.tail<6>();
  }
  for (int i = 0; i < model_.nodes(); ++i) g.col(i) += inertia_force(state, at, i);
}

// M((q - q_n)/h - v_n)/h + alpha M (q - q_n)/h - w at one node.
Vector6 NeedleMotion::inertia_force(const NeedleState& state, const Configuration& at, int i) const {
  const double alpha = model_.rayleigh_mass;
  const Vector3 velocity = (at.shape.x.col(i) - state.x.col(i)) / h_;
  const Vector3 spin = rotation_log(at.q[i] * state.q[i].conjugate()) / h_;
  const Vector3 t = at.shape.frames[i].col(0);
  const Vector3 torque = (spin - state.v.col(i).tail<3>()) / h_ + alpha * spin;
  Vector6 f;
  f << model_.mass[i] * ((velocity - state.v.col(i).head<3>()) / h_ + alpha * velocity - model_.gravity),
      model_.inertia_transverse[i] * torque +
          (model_.inertia_axial[i] - model_.inertia_transverse[i]) * t.dot(torque) * t;
  return f;
}

// M/h² + alpha M/h of one node.
void NeedleMotion::add_inertia_tangent(int i, Matrix6& block) const {
  const double factor = 1 / (h_ * h_) + model_.rayleigh_mass / h_;
  const Vector3 t = iterate_.shape.frames[i].col(0);
  block.topLeftCorner<3, 3>().diagonal().array() += factor * model_.mass[i];
  block.bottomRightCorner<3, 3>().diagonal().array() += factor * model_.inertia_transverse[i];
  block.bottomRightCorner<3, 3>() +=
      factor * (model_.inertia_axial[i] - model_.inertia_transverse[i]) * t * t.transpose();
}

void NeedleMotion::add_inertia(const NeedleState& state) {
  for (int i = 0; i < model_.nodes(); ++i) {
    g_.col(i) += inertia_force(state, iterate_, i);
    if (i > 0) add_inertia_tangent(i, matrix_.diagonal[i - 1]);
  }
}

// A force and a moment on a node, as a force and a moment on node 0.
Vector6 NeedleMotion::about_base(int node, const Vector6& wrench) const {
  const Vector3 arm = iterate_.shape.x.col(node) - iterate_.shape.x.col(0), force = wrench.head<3>();
  Vector6 moved = wrench;
  moved.tail<3>() += arm.cross(force);
  return moved;
}

bool NeedleMotion::linearize(const NeedleState& state, int held) {
  if (model_.rigid) {
    g_.setZero();
    for (int i = 0; i < model_.nodes(); ++i) g_.col(0) += about_base(i, inertia_force(state, iterate_, i));
    return !held_ || close_at_base();
  }
  if (try_tangent(state, true)) return true;
  double stiffness = 3 * model_.stiffness.bending / (model_.length * model_.length * model_.length);
  for (int i = 0; held > 0 && i < kMaxHolds; ++i) {
    stiffness *= kHoldStep;
    if (try_tangent(state, true, held, stiffness)) return false;
  }
  // With inertia it is always positive definite, of numbers that are finite.
  if (!try_tangent(state, false)) dq_free_.setConstant(std::numeric_limits<double>::quiet_NaN());
  return false;
}

// False if it is not positive definite; the free motion is put if it is.
bool NeedleMotion::try_tangent(const NeedleState& state, bool exact, int held, double stiffness) {
  g_.setZero();
  matrix_.set_zero();
  add_beams(exact);
  add_inertia(state);
  add_springs(held, stiffness);
  return matrix_.factorize() && put_free_motion();
}

void NeedleMotion::add_springs(int held, double stiffness) {
  for (int i = model_.beams; i > std::max(model_.beams - held, 0); --i) {
    const Vector3 t = iterate_.shape.frames[i].col(0);
    matrix_.diagonal[i - 1].topLeftCorner<3, 3>() += stiffness * (Matrix3::Identity() - t * t.transpose());
  }
}

bool NeedleMotion::put_free_motion() {
  for (int i = 0; i < model_.beams; ++i) dq_free_.segment<6>(6 * i) = -g_.col(i + 1);
  matrix_.forward(dq_free_);
  matrix_.backward(dq_free_);
  return !held_ || close_at_base();
}

// Adds the free step of a base that is held; false if S + K is not positive definite.
bool NeedleMotion::close_at_base() {
  follow_node(follow_);
  Matrix6 stiffness = tangent_beside(follow_);
  stiffness.diagonal() += held_->tangent();
  base_factor_.compute(stiffness);
  if (base_factor_.info() != Eigen::Success) return false;
  Vector6 reaction = g_.col(0);
  if (!model_.rigid) reaction += base_coupling_ * dq_free_.head<6>();
  base_free_ = base_factor_.solve(held_->wrench(base_of(iterate_)) - reaction);
  dq_free_.noalias() += follow_ * base_free_;
  return true;
}

int NeedleMotion::add_row(int beam, const Vector12& force) {
  assert(rows_.size() < rows_.capacity());
  rows_.push_back({beam, force});
  return static_cast<int>(rows_.size()) - 1;
}

void NeedleMotion::add_compliances(std::span<const int> places, Eigen::Ref<MatrixX> W) {
  if (!model_.rigid) compliance_.add_to(matrix_, rows_, places, W);
  if (held_) add_base_compliances(places, W);
}

void NeedleMotion::add_base_compliances(std::span<const int> places, Eigen::Ref<MatrixX> W) {
  const int count = static_cast<int>(rows_.size());
  for (int r = 0; r < count; ++r) base_rows_.row(r) = base_factor_.matrixL().solve(follow_node(r, follow_)).transpose();
  for (int r = 0; r < count; ++r)
    for (int s = 0; s <= r; ++s)
      W(std::max(places[r], places[s]), std::min(places[r], places[s])) += base_rows_.row(r).dot(base_rows_.row(s));
}

double NeedleMotion::free_displacement(int row) const {
  if (model_.rigid) return held_ ? follow_node(row, follow_).dot(base_free_) : 0;
  const auto& [beam, force] = rows_[row];
  const double far = force.tail<6>().dot(dq_free_.segment<6>(6 * beam));
  return far + force.head<6>().dot(beam == 0 ? base_free_ : Vector6(dq_free_.segment<6>(6 * (beam - 1))));
}

// Hᵀ lambda on the free nodes into applied_; the part on node 0, of a rigid needle all of it, is returned.
Vector6 NeedleMotion::add_row_forces(std::span<const double> lambda) {
  applied_.setZero();
  Vector6 on_base = Vector6::Zero();
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const int beam = rows_[r].beam;
    const Vector6 near = lambda[r] * rows_[r].force.head<6>(), far = lambda[r] * rows_[r].force.tail<6>();
    if (model_.rigid) {
      on_base += about_base(beam, near) + about_base(beam + 1, far);
      continue;
    }
    applied_.segment<6>(6 * beam) += far;
    if (beam > 0)
      applied_.segment<6>(6 * (beam - 1)) += near;
    else
      on_base += near;
  }
  return on_base;
}

void NeedleMotion::solve(std::span<const double> lambda) {
  on_base_ = add_row_forces(lambda);
  reaction_ = g_.col(0) - on_base_;
  if (!model_.rigid) {
    dq_ = applied_;
    matrix_.forward(dq_);
    matrix_.backward(dq_);
  }
  if (held_) {
    Vector6 on_base = on_base_;
    if (!model_.rigid) on_base -= base_coupling_ * dq_.head<6>();
    const Vector6 pushed = base_factor_.solve(on_base);
    base_step_ = base_free_ + pushed;
    dq_.noalias() += follow_ * pushed;
  }
  dq_ += dq_free_;
}

bool NeedleMotion::turns_far() const {
  if (!(base_step_.tail<3>().squaredNorm() <= kLargeTurn * kLargeTurn)) return true;
  for (int i = 0; i < dq_.size(); i += 6)
    if (!(dq_.segment<3>(i + 3).squaredNorm() <= kLargeTurn * kLargeTurn)) return true;
  return false;
}

double NeedleMotion::trusted_share(const NeedleState& state) {
  if (model_.rigid || !turns_far()) return 1;
  const auto slope = [&](const Matrix6X& g, const Configuration& at) {
    const double of_free = g.rightCols(model_.beams).reshaped().dot(dq_) - applied_.dot(dq_);
    return held_ ? of_free + (g.col(0) - held_->wrench(base_of(at)) - on_base_).dot(base_step_) : of_free;
  };
  const double descent = -slope(g_, iterate_);
  double share = 1;
  for (int i = 0; i < kMaxTrials; ++i) {
    go(share, trial_);
    put_residual(state, trial_, trial_g_);
    const double end = slope(trial_g_, trial_);
    if (end <= descent) break;
    share = cut_share(share, descent, end);
  }
  return share;
}

// From q_k by a share of the step; `to` may be q_k itself.
void NeedleMotion::go(double share, Configuration& to) const {
  if (model_.rigid) return turn_about_base(share, to);
  to.shape.x.col(0) = iterate_.shape.x.col(0);
  to.q[0] = iterate_.q[0];
  to.shape.frames[0] = iterate_.shape.frames[0];
  if (held_) step_node(0, share * base_step_, to);
  for (int i = 1; i < model_.nodes(); ++i) {
    step_node(i, share * dq_.segment<6>(6 * (i - 1)), to);
  }
}

void NeedleMotion::step_node(int i, const Vector6& step, Configuration& to) const {
  to.shape.x.col(i) = iterate_.shape.x.col(i) + step.head<3>();
  to.q[i] = (rotation_exp(step.tail<3>()) * iterate_.q[i]).normalized();
  to.shape.frames[i] = to.q[i].toRotationMatrix();
}

// Of a rigid needle, by the step of its base.
Vector3 NeedleMotion::step_of_tip() const {
  const Vector3 arm = iterate_.shape.x.rightCols<1>() - iterate_.shape.x.col(0);
  return base_step_.head<3>() + base_step_.tail<3>().cross(arm);
}

void NeedleMotion::turn_about_base(double share, Configuration& to) const {
  const Vector6 step = share * base_step_;
  const Quaternion turn = rotation_exp(step.tail<3>());
  const Vector3 pivot = iterate_.shape.x.col(0);
  for (int i = 0; i < model_.nodes(); ++i) {
    to.shape.x.col(i) = pivot + step.head<3>() + turn * (iterate_.shape.x.col(i) - pivot);
    to.q[i] = (turn * iterate_.q[i]).normalized();
    to.shape.frames[i] = to.q[i].toRotationMatrix();
  }
}

double NeedleMotion::move(double share) {
  assert(share > 0 && share <= 1);
  if (model_.rigid && !held_) return 0;
  reaction_ = g_.col(0) - on_base_;
  if (!model_.rigid) reaction_ = g_.col(0) + share * (base_coupling_ * dq_.head<6>()) - on_base_;
  if (held_) reaction_ += share * (node_tangent() * base_step_);
  go(share, iterate_);
  at_rigid_ = false;
  double largest = (share * base_step_.head<3>()).cwiseAbs().maxCoeff();
  if (model_.rigid) largest = std::max(largest, (share * step_of_tip()).cwiseAbs().maxCoeff());
  for (Eigen::Index i = 0; i < dq_.size(); i += 6)
    largest = std::max(largest, (share * dq_.segment<3>(i)).cwiseAbs().maxCoeff());
  return largest;
}

void NeedleMotion::follow_base(Eigen::Ref<MatrixX> dq) const {
  assert(dq.rows() == free_unknowns() && dq.cols() == 6);
  if (!held_) return follow_node(dq);
  const Matrix6 share = share_of_holder();
  dq.noalias() = follow_.lazyProduct(share);
}

Vector6 NeedleMotion::follow_base(int row, const Eigen::Ref<const MatrixX>& dq) const {
  if (!held_) return follow_node(row, dq);
  return share_of_holder().transpose() * follow_node(row, follow_);
}

Matrix6 NeedleMotion::base_tangent(const Eigen::Ref<const MatrixX>& dq) const {
  if (!held_) return tangent_beside(dq);
  const Matrix6 stiffness = held_->tangent().asDiagonal();
  return stiffness - stiffness * share_of_holder();
}

// How the base follows what holds it, (S + K)⁻¹ K.
Matrix6 NeedleMotion::share_of_holder() const { return base_factor_.solve(Matrix6(held_->tangent().asDiagonal())); }

void NeedleMotion::follow_node(Eigen::Ref<MatrixX> dq) const {
  if (model_.rigid) return;
  dq.setZero();
  dq.topRows<6>() = -base_coupling_.transpose();
  for (int axis = 0; axis < 6; ++axis) {
    matrix_.forward(dq.col(axis));
    matrix_.backward(dq.col(axis));
  }
}

Vector6 NeedleMotion::follow_node(int row, const Eigen::Ref<const MatrixX>& dq) const {
  const auto& [beam, force] = rows_[row];
  if (model_.rigid) return about_base(beam, force.head<6>()) + about_base(beam + 1, force.tail<6>());
  const Vector6 far = dq.middleRows<6>(6 * beam).transpose() * force.tail<6>();
  if (beam == 0) return far + force.head<6>();
  return far + dq.middleRows<6>(6 * (beam - 1)).transpose() * force.head<6>();
}

Matrix6 NeedleMotion::tangent_beside(const Eigen::Ref<const MatrixX>& dq) const {
  Matrix6 tangent = node_tangent();
  if (!model_.rigid) tangent.noalias() += base_coupling_ * dq.topRows<6>();
  return tangent;
}

// Of a rigid needle, that of all nodes about it.
Matrix6 NeedleMotion::node_tangent() const {
  Matrix6 tangent = Matrix6::Zero();
  if (!model_.rigid) {
    tangent = base_diagonal_;
    add_inertia_tangent(0, tangent);
    return tangent;
  }
  for (int i = 0; i < model_.nodes(); ++i) {
    Matrix6 of_node = Matrix6::Zero(), about_base;
    add_inertia_tangent(i, of_node);
    for (int axis = 0; axis < 6; ++axis) about_base.col(axis) = this->about_base(i, of_node.col(axis));
    for (int axis = 0; axis < 6; ++axis) tangent.row(axis) += this->about_base(i, about_base.row(axis).transpose());
  }
  return tangent;
}

Vector3 NeedleMotion::inertia_less_weight(const NeedleState& state) const {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < model_.nodes(); ++i) sum += inertia_force(state, iterate_, i).head<3>();
  return sum;
}

Vector6 NeedleMotion::lasting_wrench() const {
  Vector6 sum = on_base_;
  for (int i = 0; i < model_.nodes(); ++i) {
    Vector6 force = Vector6::Zero();
    if (i > 0 && !model_.rigid) force = applied_.segment<6>(6 * (i - 1));
    force.head<3>() += model_.mass[i] * model_.gravity;
    sum += about_base(i, force);
  }
  return sum;
}

Vector6 NeedleMotion::velocity(const NeedleState& state, int i) const {
  Vector6 v;
  v << (iterate_.shape.x.col(i) - state.x.col(i)) / h_, rotation_log(iterate_.q[i] * state.q[i].conjugate()) / h_;
  return v;
}

// The base's turn strains nothing: what was stored at the start of the tick is stored at q_0, too.
NeedleMotion::EnergyChange NeedleMotion::energy_change(const NeedleState& state) const {
  double kinetic = 0, work = 0;
  for (int i = 0; i < model_.nodes(); ++i) {
    const Vector6 v = velocity(state, i);
    kinetic += kinetic_energy(model_, i, iterate_.shape.frames[i].col(0), v);
    const Vector6 force = i == 0 ? Vector6(reaction_ + on_base_) : Vector6(applied_.segment<6>(6 * (i - 1)));
    work += h_ * (force.dot(v) + model_.mass[i] * model_.gravity.dot(v.head<3>()));
  }
  const double stored = kinetic + elastic_energy(model_, iterate_.shape);
  const double stored_before = kinetic_energy(model_, state) + elastic_energy(model_, rigid_.shape);
  return {stored, stored - stored_before - work};
}

double NeedleMotion::largest_strain() const {
  double largest = 0;
  for (int e = 0; e < model_.beams; ++e) {
    const auto [stiffness, a, b] = needle_beam(model_, iterate_.shape, e);
    const double stretch = std::abs((b.position - a.position).norm() / stiffness.length - 1);
    const double bend = (b.frame.col(0) - a.frame.col(0)).norm() / stiffness.length * model_.diameter / 2;
    largest = std::max(largest, stretch + bend);
  }
  return largest;
}

void NeedleMotion::commit(NeedleState& state) const {
  for (int i = 0; i < model_.nodes(); ++i) {
    state.v.col(i) = velocity(state, i);
    state.x.col(i) = iterate_.shape.x.col(i);
    state.q[i] = iterate_.q[i];
  }
}

bool NeedleMotion::finite() const { return iterate_.shape.x.allFinite() && reaction_.allFinite() && dq_.allFinite(); }

}  // namespace acus
