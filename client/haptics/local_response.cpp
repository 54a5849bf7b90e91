// SPDX-License-Identifier: MIT
#include "client/haptics/local_response.h"

#include <algorithm>
#include <cassert>

namespace acus::haptics {

namespace {

// The same 6 x 6 tensor seen in the base's frame: both halves of both sides turned.
Matrix6 in_base(const Matrix6& world, const Quaternion& base_from_world) {
  Matrix6 turned;
  for (int half_i = 0; half_i < 2; ++half_i)
    for (int half_j = 0; half_j < 2; ++half_j) {
      Matrix<3> rows;  // block R^T, its columns turned first
      for (int j = 0; j < 3; ++j) {
        Vector3 column;
        for (int i = 0; i < 3; ++i) column[i] = world(3 * half_i + i, 3 * half_j + j);
        column = base_from_world * column;
        for (int i = 0; i < 3; ++i) rows(i, j) = column[i];
      }
      for (int i = 0; i < 3; ++i) {
        const Vector3 row = base_from_world * Vector3{{rows(i, 0), rows(i, 1), rows(i, 2)}};
        for (int j = 0; j < 3; ++j) turned(3 * half_i + i, 3 * half_j + j) = row[j];
      }
    }
  return turned;
}

// Kc^(1/2) V max(lambda, 0) V' Kc^(1/2).
Matrix6 composed(const Spectrum& spectrum, const Vector6& root) {
  Matrix6 a;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      for (int k = 0; k < 6; ++k)
        a(i, j) +=
            root[i] * spectrum.vectors(i, k) * std::max(spectrum.values[k], 0.0) * spectrum.vectors(j, k) * root[j];
  return a;
}

bool yields(Limit limit) { return limit == Limit::puncture || limit == Limit::cutting || limit == Limit::slip; }

}  // namespace

LocalResponse::LocalResponse(const LocalModel& model, double translation, double rotation, double sticking,
                             double moving)
    : empty_(false), model_(model), world_from_base_(model.base.orientation) {
  assert(translation > 0 && rotation > 0 && sticking > 0 && model.forward >= 0 && model.backward >= 0);
  coupling_ = {{translation, translation, translation, rotation, rotation, rotation}};
  Vector6 root;
  for (int i = 0; i < 6; ++i) root[i] = std::sqrt(coupling_[i]);
  const Quaternion base_from_world = world_from_base_.conjugate();
  const Matrix6 stiffness = in_base(model.stiffness, base_from_world);
  Matrix6 scaled;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) scaled(i, j) = -(stiffness(i, j) + stiffness(j, i)) / (2 * root[i] * root[j]);
  resisting_ = composed(spectrum(scaled), root);
  force_ = turned(base_from_world, joined(model.felt));
  if (!model.is_free() && resisting_(0, 0) * kLongestSpring <= std::abs(force_[0]) && force_[0] != 0) {
    let_stick(sticking);
    moving = 0;
  }
  take_off(moving);
}

// Row and column shrink together, which keeps A positive semidefinite.
void LocalResponse::take_off(double moving) {
  loading_ = resisting_;
  if (!(resisting_(0, 0) > 0)) return;
  const double share = std::sqrt(std::max(1 - moving / resisting_(0, 0), 0.0));
  for (int i = 0; i < 6; ++i) {
    loading_(i, 0) *= share;
    loading_(0, i) *= share;
  }
}

// The needle slides: no further way ahead, a spring back to where it slides the other way, or if that is not known to
// where nothing is felt. Adding to the diagonal keeps A positive semidefinite.
void LocalResponse::let_stick(double sticking) {
  resisting_(0, 0) += sticking;
  const bool ahead = force_[0] < 0;
  const double change = std::max(std::abs(force_[0]), ahead ? model_.backward_change : model_.forward_change);
  model_.forward = ahead ? 0 : change / resisting_(0, 0);
  model_.backward = ahead ? change / resisting_(0, 0) : 0;
  model_.forward_limit = model_.backward_limit = Limit::slip;
}

Vector6 LocalResponse::solve_free(const Piece& piece, const Vector6& delta) const {
  Matrix6 both = piece.resisting;
  Vector6 pull = piece.force;
  for (int i = 0; i < 6; ++i) {
    both(i, i) += coupling_[i];
    pull[i] += coupling_[i] * delta[i] + piece.resisting(i, 0) * anchor_;
  }
  Vector6 gone;
  [[maybe_unused]] const bool definite = solve(both, pull, gone);
  assert(definite);
  return gone;
}

// The same with what A sees of the axial way held at `axial`; the first entry of the result is `axial`, too.
Vector6 LocalResponse::solve_clamped(const Piece& piece, const Vector6& delta, double axial) const {
  Matrix<5> both;
  Vector<5> pull;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) both(i, j) = piece.resisting(i + 1, j + 1);
    both(i, i) += coupling_[i + 1];
    pull[i] = piece.force[i + 1] + coupling_[i + 1] * delta[i + 1] - piece.resisting(i + 1, 0) * axial;
  }
  Vector<5> gone;
  [[maybe_unused]] const bool definite = solve(both, pull, gone);
  assert(definite);
  return {{axial, gone[0], gone[1], gone[2], gone[3], gone[4]}};
}

void LocalResponse::yield(double gone) {
  if (gone - anchor_ > model_.forward && yields(model_.forward_limit)) anchor_ = gone - model_.forward;
  if (gone - anchor_ < -model_.backward && yields(model_.backward_limit)) anchor_ = gone + model_.backward;
}

void LocalResponse::pass(const Pose& proxy) {
  if (empty_) return;
  yield((world_from_base_.conjugate() * (proxy.position - model_.base.position))[0]);
}

// The wrench of one piece, and what A sees of the way.
Vector6 LocalResponse::felt(const Piece& piece, const Vector6& delta, Vector6& seen) const {
  seen = solve_free(piece, delta);
  seen[0] -= anchor_;
  if (seen[0] > model_.forward)
    seen = solve_clamped(piece, delta, model_.forward);
  else if (seen[0] < -model_.backward)
    seen = solve_clamped(piece, delta, -model_.backward);
  return piece.force - piece.resisting * seen;
}

LocalResponse::Answer LocalResponse::operator()(const Pose& device) {
  if (empty_) return {{}, device};
  const Vector6 delta = turned(world_from_base_.conjugate(), displacement(model_.base, device));
  Vector6 seen;
  Vector6 wrench = felt({loading_, force_}, delta, seen);
  if (seen[0] * force_[0] > 0) {  // the way goes with the force, which falls
    wrench = felt({resisting_, force_}, delta, seen);
    if (wrench[0] * force_[0] < 0) {  // and would turn round: from where it is zero it grows the other way
      const double zero = force_[0] / resisting_(0, 0);
      Vector6 less;
      for (int i = 0; i < 6; ++i) less[i] = zero * (resisting_(i, 0) - loading_(i, 0));
      wrench = felt({loading_, force_ - less}, delta, seen);
    }
  }
  const Vector6 holding = model_.is_free() ? wrench : felt({resisting_, force_}, delta, seen);
  Vector6 gone;
  for (int i = 0; i < 6; ++i) gone[i] = delta[i] + holding[i] / coupling_[i];
  yield(gone[0]);
  if (model_.backward_limit == Limit::contact && gone[0] - anchor_ < -model_.backward) return {model_.in_air, device};
  return {wrench_of(turned(world_from_base_, wrench)), displaced(model_.base, turned(world_from_base_, gone))};
}

double LocalResponse::stored(const Wrench& felt, double softest) const {
  if (empty_) return 0;
  const double now = energy(turned(world_from_base_.conjugate(), joined(felt)), softest);
  return softest > 0 ? std::max(now, energy(force_, softest)) : now;
}

double LocalResponse::energy(const Vector6& force, double softest) const {
  const double squared = force[0] * force[0] + force[1] * force[1] + force[2] * force[2];
  double along = 0;  // N/m, of the tissue in the direction of the force
  for (int i = 0; i < 3 && squared > 0; ++i)
    for (int j = 0; j < 3; ++j) along += force[i] * loading_(i, j) * force[j] / squared;
  const double strength = std::sqrt(squared);
  const bool springs = along * kLongestSpring > strength;
  if (softest > 0) along = springs ? std::min(along, softest) : softest;
  double sum = 0;
  if (along > 0 && (springs || softest > 0)) sum = strength * std::min(strength / along, kDeepest) / 2;
  for (int i = 0; i < 6; ++i) sum += force[i] * force[i] / coupling_[i] / 2;
  return sum;
}

}  // namespace acus::haptics
