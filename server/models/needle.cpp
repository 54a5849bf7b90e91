// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/models/needle.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "server/math/rotation.h"
#include "server/math/step_share.h"

namespace acus {

namespace {

Quaternion turn_in_plane(double angle) { return rotation_exp({0, 0, angle}); }

CurvedBeam make_curved_beam(const NeedleModel& model, int beam) {
  const Pose first = rest_pose(model, beam * model.beam_length());
  const Pose second = rest_pose(model, (beam + 1) * model.beam_length());
  const Vector3 chord = second.position - first.position;
  const Quaternion base_from_chord = turn_in_plane(std::atan2(chord.y(), chord.x()));
  return {chord.norm(), (first.orientation.conjugate() * base_from_chord).toRotationMatrix(),
          (second.orientation.conjugate() * base_from_chord).toRotationMatrix()};
}

void bend(NeedleModel& model, const NeedleBody& body) {
  model.curvature = body.curvature;
  model.straight_length = body.length - body.curved_length.value_or(body.length);
  model.straight_beams = static_cast<int>(model.straight_length / model.beam_length());
  for (int e = model.straight_beams; e < model.beams; ++e) model.curved.push_back(make_curved_beam(model, e));
}

}  // namespace

NeedleModel make_needle_model(const NeedleBody& p, const Vector3& gravity, bool rigid) {
  constexpr double pi = std::numbers::pi;
  const double outer2 = p.outer_diameter * p.outer_diameter, inner2 = p.inner_diameter * p.inner_diameter;
  const double area = pi / 4 * (outer2 - inner2);
  const double second_moment = pi / 64 * (outer2 * outer2 - inner2 * inner2);
  const double shear_modulus = p.material.young_modulus / (2 * (1 + p.material.poisson_ratio));

  NeedleModel m;
  m.beams = p.beams;
  m.length = p.length;
  m.diameter = p.outer_diameter;
  m.rigid = rigid;
  m.stiffness = {p.length / p.beams, p.material.young_modulus * area, p.material.young_modulus * second_moment,
                 shear_modulus * 2 * second_moment};
  m.rayleigh_mass = p.material.rayleigh_mass;
  m.rayleigh_stiffness = p.material.rayleigh_stiffness;
  m.gravity = gravity;
  m.straight_length = p.length;
  m.straight_beams = p.beams;
  if (p.curvature != 0) bend(m, p);

  // Each node owns half of the beams beside it.
  VectorX share = VectorX::Constant(m.nodes(), m.beam_length());
  share[0] = share[m.beams] = m.beam_length() / 2;
  m.mass = p.material.density * area * share;
  m.inertia_axial = p.material.density * 2 * second_moment * share;
  m.inertia_transverse = p.material.density * second_moment * share;
  return m;
}

Pose rest_pose(const NeedleModel& model, double s) {
  if (model.curvature == 0 || s <= model.straight_length) return {Vector3(s, 0, 0), Quaternion::Identity()};
  const double along_arc = s - model.straight_length;
  const double half_angle = model.curvature * along_arc / 2;
  const double chord = half_angle == 0 ? along_arc : along_arc * std::sin(half_angle) / half_angle;
  return {{model.straight_length + chord * std::cos(half_angle), chord * std::sin(half_angle), 0},
          turn_in_plane(2 * half_angle)};
}

NeedleState make_needle_state(const NeedleModel& model, const Pose& base) {
  NeedleState state;
  state.x.resize(3, model.nodes());
  for (int i = 0; i < model.nodes(); ++i) {
    const Pose rest = rest_pose(model, i * model.beam_length());
    state.x.col(i) = base * rest.position;
    state.q.push_back(base.orientation * rest.orientation);
  }
  state.v.setZero(6, model.nodes());
  return state;
}

void put_shape(const NeedleState& state, NeedleShape& shape) {
  shape.x = state.x;
  shape.frames.resize(state.q.size());
  for (std::size_t i = 0; i < state.q.size(); ++i) shape.frames[i] = state.q[i].toRotationMatrix();
}

NeedleBeam needle_beam(const NeedleModel& model, const NeedleShape& shape, int e) {
  NeedleBeam beam{model.stiffness, {shape.x.col(e), shape.frames[e]}, {shape.x.col(e + 1), shape.frames[e + 1]}};
  if (e < model.straight_beams) return beam;
  const CurvedBeam& rest = model.curved[e - model.straight_beams];
  beam.stiffness.length = rest.chord;
  beam.a.frame *= rest.first_from_chord;
  beam.b.frame *= rest.second_from_chord;
  return beam;
}

double elastic_energy(const NeedleModel& model, const NeedleShape& shape) {
  double energy = 0;
  for (int e = 0; e < model.beams; ++e) {
    const NeedleBeam beam = needle_beam(model, shape, e);
    energy += beam_energy(beam.stiffness, beam.a, beam.b);
  }
  return energy;
}

namespace {

// Of node i with its axis along `axis` and velocities v, of its position and its turn.
double kinetic_energy(const NeedleModel& model, int i, const Vector3& axis, const Vector6& v) {
  const double along = axis.dot(v.tail<3>());
  return (model.mass[i] * v.head<3>().squaredNorm() + model.inertia_axial[i] * along * along +
          model.inertia_transverse[i] * (v.tail<3>() - along * axis).squaredNorm()) /
         2;
}

}  // namespace

double kinetic_energy(const NeedleModel& model, const NeedleState& state) {
  double energy = 0;
  for (int i = 0; i < model.nodes(); ++i)
    energy += kinetic_energy(model, i, state.q[i] * Vector3::UnitX(), state.v.col(i));
  return energy;
}

double potential_energy(const NeedleModel& model, const NeedleState& state) {
  return -model.gravity.dot(state.x * model.mass);
}

CurvePoint curve_point(const NeedleModel& model, const NeedleShape& shape, double s) {
  const double length = model.beam_length();
  CurvePoint c;
  const double inside = std::clamp(s, 0.0, model.length);
  c.beam = inside > 0 ? std::min(static_cast<int>(inside / length), model.beams - 1) : 0;  // not a number: 0, too
  const double u = c.u = std::clamp(inside / length - c.beam, 0.0, 1.0), v = 1 - u;
  c.h00 = v * v * (1 + 2 * u);
  c.h01 = u * u * (3 - 2 * u);
  c.h10 = length * u * v * v;
  c.h11 = -length * u * u * v;

  const auto& x1 = shape.x.col(c.beam);
  const auto& x2 = shape.x.col(c.beam + 1);
  const Vector3 t1 = shape.frames[c.beam].col(0), t2 = shape.frames[c.beam + 1].col(0);
  c.position = c.h00 * x1 + c.h01 * x2 + c.h10 * t1 + c.h11 * t2;
  c.tangent = (6 * u * v / length * (x2 - x1) + v * (v - 2 * u) * t1 + u * (u - 2 * v) * t2).normalized();
  c.position += (s - inside) * c.tangent;
  return c;
}

Vector12 curve_force(const NeedleShape& shape, const CurvePoint& c, const Vector3& n) {
  const Vector3 t1 = shape.frames[c.beam].col(0), t2 = shape.frames[c.beam + 1].col(0);
  Vector12 f;
  f << c.h00 * n, c.h10 * t1.cross(n), c.h01 * n, c.h11 * t2.cross(n);
  return f;
}

Vector12 curve_torque(const CurvePoint& c, const Vector3& torque) {
  Vector12 f = Vector12::Zero();
  f.segment<3>(3) = (1 - c.u) * torque;
  f.tail<3>() = c.u * torque;
  return f;
}

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
}

void NeedleMotion::begin(const NeedleState& state, const Pose& base) {
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

bool NeedleMotion::linearize(const NeedleState& state) {
  if (model_.rigid) {
    g_.setZero();
    for (int i = 0; i < model_.nodes(); ++i) g_.col(0) += about_base(i, inertia_force(state, iterate_, i));
    return true;
  }
  bool exact = true;
  for (int attempt = 0; attempt < 2; ++attempt) {
    g_.setZero();
    matrix_.set_zero();
    add_beams(exact);
    add_inertia(state);
    if (matrix_.factorize()) break;
    exact = false;  // the material tangent with inertia is always positive definite
  }
  for (int i = 0; i < model_.beams; ++i) dq_free_.segment<6>(6 * i) = -g_.col(i + 1);
  matrix_.forward(dq_free_);
  matrix_.backward(dq_free_);
  return exact;
}

int NeedleMotion::add_row(int beam, const Vector12& force) {
  assert(rows_.size() < rows_.capacity());
  rows_.push_back({beam, force});
  return static_cast<int>(rows_.size()) - 1;
}

void NeedleMotion::add_compliances(std::span<const int> places, Eigen::Ref<MatrixX> W) {
  if (!model_.rigid) compliance_.add_to(matrix_, rows_, places, W);
}

double NeedleMotion::free_displacement(int row) const {
  if (model_.rigid) return 0;
  const auto& [beam, force] = rows_[row];
  const double far = force.tail<6>().dot(dq_free_.segment<6>(6 * beam));
  return beam == 0 ? far : far + force.head<6>().dot(dq_free_.segment<6>(6 * (beam - 1)));
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
  if (model_.rigid) return;
  dq_ = applied_;
  matrix_.forward(dq_);
  matrix_.backward(dq_);
  dq_ += dq_free_;
}

bool NeedleMotion::turns_far() const {
  for (int i = 0; i < dq_.size(); i += 6)
    if (!(dq_.segment<3>(i + 3).squaredNorm() <= kLargeTurn * kLargeTurn)) return true;
  return false;
}

double NeedleMotion::trusted_share(const NeedleState& state) {
  if (!turns_far()) return 1;
  const auto slope = [&](const Matrix6X& g) { return g.rightCols(model_.beams).reshaped().dot(dq_) - applied_.dot(dq_); };
  const double descent = -slope(g_);
  double share = 1;
  for (int i = 0; i < kMaxTrials; ++i) {
    go(share, trial_);
    put_residual(state, trial_, trial_g_);
    const double end = slope(trial_g_);
    if (end <= descent) break;
    share = cut_share(share, descent, end);
  }
  return share;
}

// From q_k by a share of the step; `to` may be q_k itself.
void NeedleMotion::go(double share, Configuration& to) const {
  to.shape.x.col(0) = iterate_.shape.x.col(0);
  to.q[0] = iterate_.q[0];
  to.shape.frames[0] = iterate_.shape.frames[0];
  for (int i = 1; i < model_.nodes(); ++i) {
    const Vector6 step = share * dq_.segment<6>(6 * (i - 1));
    to.shape.x.col(i) = iterate_.shape.x.col(i) + step.head<3>();
    to.q[i] = (rotation_exp(step.tail<3>()) * iterate_.q[i]).normalized();
    to.shape.frames[i] = to.q[i].toRotationMatrix();
  }
}

double NeedleMotion::move(double share) {
  assert(share > 0 && share <= 1);
  if (model_.rigid) return 0;
  reaction_ = g_.col(0) + share * (base_coupling_ * dq_.head<6>()) - on_base_;
  go(share, iterate_);
  at_rigid_ = false;
  double largest = 0;
  for (int i = 0; i < model_.beams; ++i)
    largest = std::max(largest, (share * dq_.segment<3>(6 * i)).cwiseAbs().maxCoeff());
  return largest;
}

void NeedleMotion::follow_base(Eigen::Ref<MatrixX> dq) const {
  assert(dq.rows() == free_unknowns() && dq.cols() == 6);
  if (model_.rigid) return;
  dq.setZero();
  dq.topRows<6>() = -base_coupling_.transpose();
  for (int axis = 0; axis < 6; ++axis) {
    matrix_.forward(dq.col(axis));
    matrix_.backward(dq.col(axis));
  }
}

Vector6 NeedleMotion::follow_base(int row, const Eigen::Ref<const MatrixX>& dq) const {
  const auto& [beam, force] = rows_[row];
  if (model_.rigid) return about_base(beam, force.head<6>()) + about_base(beam + 1, force.tail<6>());
  const Vector6 far = dq.middleRows<6>(6 * beam).transpose() * force.tail<6>();
  if (beam == 0) return far + force.head<6>();
  return far + dq.middleRows<6>(6 * (beam - 1)).transpose() * force.head<6>();
}

Matrix6 NeedleMotion::base_tangent(const Eigen::Ref<const MatrixX>& dq) const {
  Matrix6 tangent = Matrix6::Zero();
  if (!model_.rigid) {
    tangent = base_diagonal_ + base_coupling_ * dq.topRows<6>();
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
