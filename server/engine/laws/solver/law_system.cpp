// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/law_system.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace acus {

void copy(const LawState& from, const LawState& to) {
  std::copy(from.lambda.begin(), from.lambda.end(), to.lambda.begin());
  std::copy(from.delta.begin(), from.delta.end(), to.delta.begin());
}

double force_scale(std::span<const double> lambda) {
  double largest = 1;
  for (const double force : lambda) largest = std::max(largest, std::abs(force));
  return largest;
}

void law_scales(const Eigen::Ref<const MatrixX>& W, std::span<const Law> laws, std::span<double> scale) {
  assert(scale.size() >= laws.size());
  for (int i = 0; i < static_cast<int>(laws.size()); ++i) {
    scale[i] = W(i, i);
    // No eigenvalue of the block is larger.
    if (laws[i].kind == LawKind::disk_first) scale[i] = std::max(W(i, i), W(i + 1, i + 1)) + std::abs(W(i, i + 1));
  }
}

void update_displacements(const LawSystem& system, const LawState& state) {
  assert(state.lambda.size() == system.laws.size() && state.delta.size() == system.laws.size());
  Eigen::Map<VectorX> delta(state.delta.data(), system.rows());
  delta = Eigen::Map<const VectorX>(system.delta_free.data(), system.rows());
  for (int i = 0; i < system.rows(); ++i)
    if (state.lambda[i] != 0) delta += state.lambda[i] * system.W.col(i);
}

DiskContact cone_answer(const LawSystem& system, int i, const LawState& state) {
  const FrictionCone& cone = *system.laws[i].cone;
  Eigen::Matrix2d block = system.W(i, i) * Eigen::Matrix2d::Identity();
  Eigen::Vector2d lambda(state.lambda[i], 0), delta(state.delta[i], 0);
  if (cone_rows(system.laws, i) == 2) {
    block = system.W.block<2, 2>(i, i);
    lambda[1] = state.lambda[i + 1], delta[1] = state.delta[i + 1];
  }
  return cone_contact(cone, block, delta - block * lambda, delta);
}

double distance(const LawSystem& system, int i, const LawState& state, const DiskContact& answer) {
  const bool two = cone_rows(system.laws, i) == 2;
  return std::hypot(answer.force[0] - state.lambda[i], two ? answer.force[1] - state.lambda[i + 1] : 0);
}

double work_of_curves(std::span<const Law> laws) {
  constexpr double kCone = 3e3, kContact = 3e4;
  double work = 0;
  for (int i = 0; i < static_cast<int>(laws.size()); ++i)
    work += (cone_rows(laws, i) > 0 ? kCone : 0) + (is_contact(laws, i) ? kContact : 0);
  return work;
}

Eigen::Vector2d disk_step(const LawSystem& system, int i, const LawState& state) {
  const Law& law = system.laws[i];
  assert(law.kind == LawKind::disk_first);
  if (law.cone != nullptr) return cone_answer(system, i, state).force;
  const double radius = law.cohesion + law.limit * std::max(state.lambda[law.normal_row], 0.0);
  return disk_force(radius, system.scale[i], {state.lambda[i], state.lambda[i + 1]},
                    {state.delta[i], state.delta[i + 1]});
}

double law_violation(const LawSystem& system, int i, const LawState& state) {
  const Law& law = system.laws[i];
  const double lambda = state.lambda[i];
  if (law.kind == LawKind::disk_second) return 0;
  if (law.cone != nullptr) return distance(system, i, state, cone_answer(system, i, state));
  if (law.kind == LawKind::disk_first)
    return (disk_step(system, i, state) - Eigen::Vector2d(lambda, state.lambda[i + 1])).norm();
  return std::abs(law_force(law, system.scale[i], state.delta[i] - system.scale[i] * lambda) - lambda);
}

double law_residual(const LawSystem& system, const LawState& state) {
  double largest = 0;
  for (int i = 0; i < system.rows(); ++i) {
    const double violation = law_violation(system, i, state);
    if (!(violation <= largest)) largest = violation;
    if (std::isnan(largest)) break;
  }
  return largest;
}

}  // namespace acus
