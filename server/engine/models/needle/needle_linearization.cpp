// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/needle_linearization.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "server/engine/math/rotation.h"
#include "server/engine/models/needle/needle_base.h"
#include "server/engine/models/needle/needle_terms.h"
#include "server/engine/models/needle/rigid_needle.h"

namespace acus {

namespace {

constexpr int kMaxSprings = 3;     // stiffnesses of springs across the end, tried in one linearisation
constexpr double kSpringStep = 8;  // from one to the next

void add_beams(const NeedleModel& model, bool exact, NeedleScratch& scratch) {
  const double damping = model.rayleigh_stiffness / scratch.h;
  for (int e = 0; e < model.beams; ++e) {
    const auto [stiffness, a, b] = needle_beam(model, scratch.iterate.shape, e);
    Vector12 force = beam_forces(stiffness, a, b);
    Matrix12 tangent = exact ? beam_tangent(stiffness, a, b) : beam_material_tangent(stiffness, a, b);
    if (damping > 0) {
      const Matrix12 material = scratch.is_carried ? scratch.material[e] : turned_material(scratch, scratch.iterate, e);
      tangent += damping * material;
      if (!scratch.is_carried) force += beam_damping_force(model, scratch, scratch.iterate, e, material);
    }
    scratch.g.col(e) += force.head<6>();
    scratch.g.col(e + 1) += force.tail<6>();
    scratch.matrix.diagonal[e] += tangent.bottomRightCorner<6, 6>();
    if (e > 0) {
      scratch.matrix.diagonal[e - 1] += tangent.topLeftCorner<6, 6>();
      scratch.matrix.lower[e - 1] = tangent.bottomLeftCorner<6, 6>();
    } else {
      scratch.base_coupling = tangent.topRightCorner<6, 6>();
      scratch.base_diagonal = tangent.topLeftCorner<6, 6>();
    }
  }
}

void add_inertia(const NeedleModel& model, const NeedleState& state, NeedleScratch& scratch) {
  for (int i = 0; i < model.nodes(); ++i) {
    scratch.g.col(i) += inertia_force(model, scratch, state, scratch.iterate, i);
    if (i > 0) add_inertia_tangent(model, scratch, i, scratch.matrix.diagonal[i - 1]);
  }
}

void add_springs(const NeedleModel& model, int held, double stiffness, NeedleScratch& scratch) {
  for (int i = model.beams; i > std::max(model.beams - held, 0); --i) {
    const Vector3 t = scratch.iterate.shape.frames[i].col(0);
    scratch.matrix.diagonal[i - 1].topLeftCorner<3, 3>() += stiffness * (Matrix3::Identity() - t * t.transpose());
  }
}

bool put_free_motion(const NeedleModel& model, NeedleScratch& scratch) {
  for (int i = 0; i < model.beams; ++i) scratch.dq_free.segment<6>(6 * i) = -scratch.g.col(i + 1);
  scratch.matrix.forward(scratch.dq_free);
  scratch.matrix.backward(scratch.dq_free);
  return !scratch.held || close_at_base(model, scratch);
}

// False if it is not positive definite; the free motion is put if it is.
bool try_tangent(const NeedleModel& model, const NeedleState& state, bool exact, int held, double stiffness,
                 NeedleScratch& scratch) {
  scratch.g.setZero();
  scratch.matrix.set_zero();
  add_beams(model, exact, scratch);
  add_inertia(model, state, scratch);
  add_springs(model, held, stiffness, scratch);
  return scratch.matrix.factorize() && put_free_motion(model, scratch);
}

bool linearize_rigid_needle(const NeedleModel& model, const NeedleState& state, NeedleScratch& scratch) {
  scratch.g.setZero();
  for (int i = 0; i < model.nodes(); ++i)
    scratch.g.col(0) += about_base(scratch, i, inertia_force(model, scratch, state, scratch.iterate, i));
  return !scratch.held || close_at_base(model, scratch);
}

}  // namespace

void begin_needle(const NeedleModel& model, const NeedleState& state, const Pose& commanded, const Pose& before,
                  NeedleScratch& scratch) {
  if (scratch.held) scratch.held->begin(before, commanded, {state.x.col(0), state.q[0]});
  const Pose base = scratch.held ? scratch.held->carried_along() : commanded;
  const Quaternion turn = base.orientation * state.q[0].conjugate();
  const Vector3 pivot = state.x.col(0);
  for (int i = 0; i < model.nodes(); ++i) {
    scratch.iterate.shape.x.col(i) = base.position + turn * (state.x.col(i) - pivot);
    scratch.iterate.q[i] = (turn * state.q[i]).normalized();
    scratch.iterate.shape.frames[i] = scratch.iterate.q[i].toRotationMatrix();
  }
  scratch.carried = scratch.iterate;
  scratch.is_carried = true;
  if (model.rayleigh_stiffness == 0 || model.rigid) return;
  for (int e = 0; e < model.beams; ++e) {
    const NeedleBeam beam = needle_beam(model, scratch.carried.shape, e);
    scratch.material[e] = beam_material_tangent(beam.stiffness, beam.a, beam.b);
  }
}

bool linearize_needle(const NeedleModel& model, const NeedleState& state, int held, NeedleScratch& scratch) {
  if (model.rigid) return linearize_rigid_needle(model, state, scratch);
  if (try_tangent(model, state, true, 0, 0, scratch)) return true;
  double stiffness = 3 * model.stiffness.bending / (model.length * model.length * model.length);
  for (int i = 0; held > 0 && i < kMaxSprings; ++i) {
    stiffness *= kSpringStep;
    if (try_tangent(model, state, true, held, stiffness, scratch)) return false;
  }
  // With inertia it is always positive definite, of numbers that are finite.
  if (!try_tangent(model, state, false, 0, 0, scratch))
    scratch.dq_free.setConstant(std::numeric_limits<double>::quiet_NaN());
  return false;
}

}  // namespace acus
