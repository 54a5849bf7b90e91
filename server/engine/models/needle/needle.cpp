// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/needle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/engine/math/rotation.h"

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

NeedleModel make_needle_model(const NeedleBody& p, const Vector3& gravity, bool rigid,
                              const std::optional<BaseHold>& hold) {
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
  m.hold = hold;
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

double kinetic_energy(const NeedleModel& model, int i, const Vector3& axis, const Vector6& v) {
  const double along = axis.dot(v.tail<3>());
  return (model.mass[i] * v.head<3>().squaredNorm() + model.inertia_axial[i] * along * along +
          model.inertia_transverse[i] * (v.tail<3>() - along * axis).squaredNorm()) /
         2;
}

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

}  // namespace acus
