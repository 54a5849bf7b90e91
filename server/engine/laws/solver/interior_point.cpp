// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/solver/interior_point.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "server/engine/math/factor/partial_cholesky.h"

namespace acus {

void InteriorPoint::Side::set_step(double change) {
  if (!bounded) return;
  slack_step = change;
  pressure_step = (target - pressure * change) / slack - pressure;
}

double InteriorPoint::Range::stiffness() const {
  if (pinned) return 1 / viscosity;
  const double d = lower.stiffness() + upper.stiffness();
  return d / (1 + viscosity * d);
}

double InteriorPoint::Range::pull() const {
  if (pinned) return 0;
  const double d = lower.stiffness() + upper.stiffness();
  return (lower.push() - upper.push() + d * force) / (1 + viscosity * d);
}

void InteriorPoint::Range::set_step(double lambda) {
  const double delta = pull() - stiffness() * lambda;
  const double change = lambda + viscosity * delta - force;
  lower.set_step(change);
  upper.set_step(-change);
}

InteriorPoint::InteriorPoint(int capacity, const std::span<double>& room) : room_(room) {
  const auto n = static_cast<std::size_t>(capacity);
  rows_.reserve(n);
  ranges_.reserve(n);
  free_.setZero(capacity);
  lambda_.setZero(capacity);
}

// Every row in the middle of its range.
void InteriorPoint::begin(const LawSystem& system, const LawState& state) {
  rows_.clear();
  ranges_.clear();
  for (int i = 0; i < system.rows(); ++i) {
    if (is_contact(system.laws, i))
      i += 2;
    else
      begin_range(system, i, state);
  }
  update_displacements(system, state);
  double push = 0;  // N, by which a row would move on average
  for (std::size_t a = 0; a < rows_.size(); ++a) {
    const int i = rows_[a];
    free_[static_cast<Eigen::Index>(a)] = state.delta[i];
    push += std::abs(state.delta[i]) / system.scale[i] / static_cast<double>(rows_.size());
  }
  for (std::size_t a = 0; a < rows_.size(); ++a) {
    ranges_[a].lower.pressure = ranges_[a].upper.pressure = push;
    state.lambda[rows_[a]] = ranges_[a].force;
  }
}

void InteriorPoint::begin_range(const LawSystem& system, int row, const LawState& state) {
  const Law& law = system.laws[row];
  const bool unilateral = law.kind == LawKind::unilateral, finite = std::isfinite(law.limit);
  if ((!unilateral && law.kind != LawKind::friction) || law.cone != nullptr) return;
  state.lambda[row] = 0;
  if (law.limit == 0 && law.viscosity == 0) return;
  Range range;
  range.viscosity = law.viscosity * system.scale[row];
  range.pinned = law.limit == 0;
  range.lower.bounded = !range.pinned && (unilateral || finite);
  range.upper.bounded = !range.pinned && finite;
  if (unilateral) range.force = finite ? law.limit / 2 : 1;
  range.lower.slack = unilateral ? range.force : law.limit;
  range.upper.slack = law.limit - range.force;
  rows_.push_back(row);
  ranges_.push_back(range);
}

bool InteriorPoint::factorize(const LawSystem& system) {
  const auto n = static_cast<Eigen::Index>(rows_.size());
  auto matrix = this->matrix();
  gather_lower(system.W, rows_, matrix);
  for (Eigen::Index a = 0; a < n; ++a)
    matrix(a, a) += system.scale[rows_[a]] * (ranges_[a].stiffness() + kRegularization);
  return partial_cholesky(matrix, n);
}

// The forces with which every product meets its target, as far as Newton sees, and the changes that they bring.
void InteriorPoint::find_step(const LawSystem& system) {
  const auto n = static_cast<Eigen::Index>(rows_.size());
  auto lambda = lambda_.head(n);
  for (Eigen::Index a = 0; a < n; ++a) lambda[a] = system.scale[rows_[a]] * ranges_[a].pull() - free_[a];
  cholesky_solve(matrix(), lambda);
  for (Eigen::Index a = 0; a < n; ++a) ranges_[a].set_step(lambda[a]);
}

// The longest step, up to 1, that leaves every slack and pressure positive.
double InteriorPoint::longest_step() const {
  double step = 1;
  for (const Range& range : ranges_)
    for (const Side* side : {&range.lower, &range.upper}) {
      if (!side->bounded) continue;
      if (side->slack_step < 0) step = std::min(step, -side->slack / side->slack_step);
      if (side->pressure_step < 0) step = std::min(step, -side->pressure / side->pressure_step);
    }
  return step;
}

// The mean of slack x pressure after a step (N²).
double InteriorPoint::mean_product(double step) const {
  double sum = 0;
  int count = 0;
  for (const Range& range : ranges_)
    for (const Side* side : {&range.lower, &range.upper}) {
      if (!side->bounded) continue;
      sum += (side->slack + step * side->slack_step) * (side->pressure + step * side->pressure_step);
      ++count;
    }
  return count == 0 ? 0 : sum / count;
}

// The predictor wants all products zero, the corrector mu, less what the predictor's step has left out.
void InteriorPoint::set_targets(double mu, bool corrector) {
  for (Range& range : ranges_)
    for (Side* side : {&range.lower, &range.upper})
      side->target = corrector ? mu - side->slack_step * side->pressure_step : 0;
}

void InteriorPoint::advance(const LawSystem& system, double step, const LawState& state) {
  for (std::size_t a = 0; a < rows_.size(); ++a) {
    Range& range = ranges_[a];
    double& lambda = state.lambda[rows_[a]];
    lambda += step * (lambda_[static_cast<Eigen::Index>(a)] - lambda);
    range.force += step * range.lower.slack_step;
    for (Side* side : {&range.lower, &range.upper}) {
      side->slack += step * side->slack_step;
      side->pressure += step * side->pressure_step;
    }
  }
  update_displacements(system, state);
}

int InteriorPoint::solve(const LawSystem& system, const LawState& state, StepBudget& budget) {
  begin(system, state);
  int iterations = 0;
  const double work = StepBudget::factorisation(static_cast<double>(rows_.size())) +
                      2 * StepBudget::product(system.rows()) + work_of_curves(system.laws);
  for (double residual = std::numeric_limits<double>::infinity();
       iterations < kMaxIterations && residual > kIterationsEnd * force_scale(state.lambda) && budget.take(work);
       ++iterations) {
    set_targets(0, false);
    if (!factorize(system)) return iterations;
    find_step(system);
    const double now = mean_product(0), ahead = mean_product(longest_step());
    const double sigma = now > 0 ? std::pow(ahead / now, 3) : 0;
    set_targets(sigma * now, true);
    find_step(system);
    advance(system, std::min(1.0, kToBoundary * longest_step()), state);
    residual = law_residual(system, state);
  }
  return iterations;
}

}  // namespace acus
