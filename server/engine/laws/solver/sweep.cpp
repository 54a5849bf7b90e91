// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/sweep.h"

#include "server/engine/laws/contact_block.h"

namespace acus {

namespace {

Vector3 contact_step(const LawSystem& system, int i, const LawState& state) {
  const Law &normal = system.laws[i], &friction = system.laws[i + 1];
  const Matrix3 block = system.W.block<3, 3>(i, i);
  const Eigen::Map<const Vector3> lambda(&state.lambda[i]), delta(&state.delta[i]);
  return contact_force({normal.limit, friction.limit, friction.cohesion}, block, delta - block * lambda);
}

double row_step(const LawSystem& system, int i, const LawState& state) {
  const double slope = system.W(i, i);
  return law_force(system.laws[i], slope, state.delta[i] - slope * state.lambda[i]);
}

}  // namespace

void sweep(const LawSystem& system, const LawState& state) {
  Eigen::Map<VectorX> delta(state.delta.data(), system.rows());
  const auto move = [&](int i, double force) {
    const double change = force - state.lambda[i];
    if (change == 0) return;
    delta += change * system.W.col(i);
    state.lambda[i] = force;
  };
  for (int i = 0; i < system.rows(); ++i) {
    if (is_contact(system.laws, i)) {
      const Vector3 force = contact_step(system, i, state);
      for (int k = 0; k < 3; ++k) move(i + k, force[k]);
      i += 2;
    } else if (system.laws[i].kind == LawKind::disk_first) {
      const Eigen::Vector2d force = disk_step(system, i, state);
      for (int k = 0; k < 2; ++k) move(i + k, force[k]);
      ++i;
    } else {
      move(i, row_step(system, i, state));
    }
  }
}

}  // namespace acus
