// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/needle_terms.h"

#include "server/engine/math/rotation.h"

namespace acus {

namespace {

// A beam's turn from q_0 to q, the mean of its nodes'.
Matrix3 beam_turn(const NeedleScratch& scratch, const NeedleConfiguration& at, int e) {
  const Vector3 first = rotation_log(at.q[e] * scratch.carried.q[e].conjugate());
  const Vector3 second = rotation_log(at.q[e + 1] * scratch.carried.q[e + 1].conjugate());
  return rotation_exp((first + second) / 2).toRotationMatrix();
}

}  // namespace

Vector12 beam_damping_force(const NeedleModel& model, const NeedleScratch& scratch, const NeedleConfiguration& at,
                            int e, const Matrix12& turned_material) {
  const Matrix3 turn = beam_turn(scratch, at, e);
  const Matrix3X &x = at.shape.x, &x_rigid = scratch.carried.shape.x;
  const Vector3 stretch = x.col(e + 1) - x.col(e) - turn * (x_rigid.col(e + 1) - x_rigid.col(e));
  const Quaternion back(turn.transpose());
  Vector12 moved;
  moved << -stretch / 2, rotation_log(at.q[e] * (back.conjugate() * scratch.carried.q[e]).conjugate()), stretch / 2,
      rotation_log(at.q[e + 1] * (back.conjugate() * scratch.carried.q[e + 1]).conjugate());
  return model.rayleigh_stiffness / scratch.h * turned_material * moved;
}

Matrix12 turned_material(const NeedleScratch& scratch, const NeedleConfiguration& at, int e) {
  const Matrix3 turn = beam_turn(scratch, at, e);
  Matrix12 turned;
  for (int i = 0; i < 12; i += 3)
    for (int j = 0; j < 12; j += 3)
      turned.block<3, 3>(i, j) = turn * scratch.material[e].block<3, 3>(i, j) * turn.transpose();
  return turned;
}

Vector6 inertia_force(const NeedleModel& model, const NeedleScratch& scratch, const NeedleState& state,
                      const NeedleConfiguration& at, int i) {
  const double alpha = model.rayleigh_mass;
  const Vector3 velocity = (at.shape.x.col(i) - state.x.col(i)) / scratch.h;
  const Vector3 spin = rotation_log(at.q[i] * state.q[i].conjugate()) / scratch.h;
  const Vector3 t = at.shape.frames[i].col(0);
  const Vector3 torque = (spin - state.v.col(i).tail<3>()) / scratch.h + alpha * spin;
  Vector6 f;
  f << model.mass[i] * ((velocity - state.v.col(i).head<3>()) / scratch.h + alpha * velocity - model.gravity),
      model.inertia_transverse[i] * torque + (model.inertia_axial[i] - model.inertia_transverse[i]) * t.dot(torque) * t;
  return f;
}

void add_inertia_tangent(const NeedleModel& model, const NeedleScratch& scratch, int i, Matrix6& block) {
  const double factor = 1 / (scratch.h * scratch.h) + model.rayleigh_mass / scratch.h;
  const Vector3 t = scratch.iterate.shape.frames[i].col(0);
  block.topLeftCorner<3, 3>().diagonal().array() += factor * model.mass[i];
  block.bottomRightCorner<3, 3>().diagonal().array() += factor * model.inertia_transverse[i];
  block.bottomRightCorner<3, 3>() +=
      factor * (model.inertia_axial[i] - model.inertia_transverse[i]) * t * t.transpose();
}

void put_residual(const NeedleModel& model, const NeedleScratch& scratch, const NeedleState& state,
                  const NeedleConfiguration& at, Matrix6X& g) {
  g.setZero();
  for (int e = 0; e < model.beams; ++e) {
    const auto [stiffness, a, b] = needle_beam(model, at.shape, e);
    Vector12 force = beam_forces(stiffness, a, b);
    if (model.rayleigh_stiffness > 0)
      force += beam_damping_force(model, scratch, at, e, turned_material(scratch, at, e));
    g.col(e) += force.head<6>();
    g.col(e + 1) += force.tail<6>();
  }
  for (int i = 0; i < model.nodes(); ++i) g.col(i) += inertia_force(model, scratch, state, at, i);
}

}  // namespace acus
