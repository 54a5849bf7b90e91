// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/laws/law_problems.h"
#include "tests/support/dense.h"

#include <algorithm>
#include <cmath>

namespace acus {

namespace {

// Branches of the one-row laws: the graph is the line alpha lambda + beta delta = gamma there.
struct Branch {
  double alpha, beta, gamma;
};

std::vector<Branch> branches(const Law& law) {
  switch (law.kind) {
    case LawKind::bilateral:
      return {{law.compliance, 1, 0}};
    case LawKind::unilateral:
      return {{1, 0, 0}, {0, 1, 0}, {1, 0, law.limit}};
    default:
      return {{0, 1, 0}, {1, law.viscosity, -law.limit}, {1, law.viscosity, law.limit}};
  }
}

// Distances of a point, in units of its largest force and displacement, from the nearest point of a graph's pieces.
double off_friction(double lambda, double delta, double limit, double viscosity) {
  const double stick = std::max(std::abs(delta), std::abs(lambda) - limit);
  const double slip = std::abs(lambda + std::copysign(limit, delta) + viscosity * delta);
  return std::min(stick, slip);
}

double off_unilateral(double lambda, double delta, double limit) {
  const double open = std::max(std::abs(lambda), -delta);
  const double closed = std::max({std::abs(delta), -lambda, lambda - limit});
  const double capped = std::max(std::abs(lambda - limit), delta);
  return std::min({open, closed, capped});
}

double off_disk(const Eigen::Vector2d& force, const Eigen::Vector2d& slip, double radius) {
  const double inside = std::max(slip.norm(), force.norm() - radius);
  const double on_rim =
      std::max(std::abs(force.norm() - radius), radius == 0 ? 0 : (slip + slip.norm() / radius * force).norm());
  return std::min(inside, on_rim);
}

MatrixX gram(const MatrixX& g) { return g * g.transpose(); }

}  // namespace

Answer solve(ConstraintSolver& solver, const Problem& p, LawMethod method, Effort effort, const VectorX& start) {
  Answer a;
  a.lambda = start.size() > 0 ? start : VectorX::Zero(p.rows());
  a.delta = VectorX::Zero(p.rows());
  const auto n = static_cast<std::size_t>(p.rows());
  a.result = solver.solve(method, p.W, p.laws, {p.delta_free.data(), n}, effort.max_steps, effort.tolerance,
                          {a.lambda.data(), n}, {a.delta.data(), n});
  return a;
}

Answer solve(const Problem& p, LawMethod method, Effort effort, const VectorX& start) {
  ConstraintSolver solver(p.rows() + 3);
  return solve(solver, p, method, effort, start);
}

std::optional<VectorX> enumerate(const Problem& p) {
  const int n = p.rows();
  std::vector<std::vector<Branch>> choices;
  std::size_t combinations = 1;
  for (const Law& law : p.laws) {
    choices.push_back(branches(law));
    combinations *= choices.back().size();
  }
  for (std::size_t c = 0; c < combinations; ++c) {
    MatrixX system(n, n);
    Answer a;
    VectorX rhs(n);
    std::size_t rest = c;
    for (int i = 0; i < n; ++i) {
      const auto& options = choices[static_cast<std::size_t>(i)];
      const Branch& b = options[rest % options.size()];
      rest /= options.size();
      system.row(i) = b.beta * p.W.row(i);
      system(i, i) += b.alpha;
      rhs[i] = b.gamma - b.beta * p.delta_free[i];
    }
    a.lambda = test::solve_dense(system, rhs);
    if (!a.lambda.allFinite()) continue;
    a.delta = p.W * a.lambda + p.delta_free;
    if (off_graphs(p, a) < 1e-9) return a.lambda;
  }
  return std::nullopt;
}

double off_graphs(const Problem& p, const Answer& a) {
  const double force = std::max(1.0, a.lambda.cwiseAbs().maxCoeff());
  // Displacements by what the largest force would do to the row, and at least by the free one.
  double worst = 0;
  for (int i = 0; i < p.rows(); ++i) {
    const Law& law = p.laws[static_cast<std::size_t>(i)];
    const double length = p.W(i, i) * force + std::abs(p.delta_free[i]);
    const double lambda = a.lambda[i] / force, delta = a.delta[i] / length, limit = law.limit / force;
    switch (law.kind) {
      case LawKind::bilateral:
        worst = std::max(worst, std::abs(delta + law.compliance * lambda * force / length));
        break;
      case LawKind::unilateral:
        worst = std::max(worst, off_unilateral(lambda, delta, limit));
        break;
      case LawKind::friction:
        worst = std::max(worst, off_friction(lambda, delta, limit, law.viscosity * length / force));
        break;
      case LawKind::disk_first: {
        const double size = std::max(p.W(i, i), p.W(i + 1, i + 1)) * force + p.delta_free.segment<2>(i).norm();
        const double radius = (law.cohesion + law.limit * std::max(0.0, a.lambda[law.normal_row])) / force;
        worst = std::max(worst, off_disk(a.lambda.segment<2>(i) / force, a.delta.segment<2>(i) / size, radius));
        break;
      }
      case LawKind::disk_second:
        break;
    }
  }
  return worst;
}

MatrixX random_compliance(int n, Random& random) { return gram(random.matrix(n, n)) + 0.05 * MatrixX::Identity(n, n); }

Law random_law(Random& random) {
  switch (random.index(8)) {
    case 0:
      return {LawKind::bilateral};
    case 1:
      return {.kind = LawKind::bilateral, .compliance = random.uniform(0, 2)};
    case 2:
      return {LawKind::unilateral, random.uniform(0, 2)};
    case 3:
      return {LawKind::unilateral, 1e6};
    case 4:
      return {LawKind::friction, 0};
    case 5:
      return {LawKind::friction, 0, random.uniform(0.1, 5)};
    case 6:
      return {LawKind::friction, random.uniform(0, 1), random.uniform(0, 5)};
    default:
      return {LawKind::friction, random.uniform(0, 1)};
  }
}

void append_contact(Problem& p, Random& random) {
  const int row = p.rows();
  const double mu = random.uniform(0, 0.8), cap = random.index(2) == 0 ? kInfinite : random.uniform(0.1, 2);
  const double cohesion = random.index(2) == 0 ? 0 : random.uniform(0, 0.5);
  p.laws.push_back({LawKind::unilateral, cap});
  p.laws.push_back({.kind = LawKind::disk_first, .limit = mu, .normal_row = row, .cohesion = cohesion});
  p.laws.push_back({.kind = LawKind::disk_second, .limit = mu, .normal_row = row, .cohesion = cohesion});
}

Problem contact_problem(Random& random, double mu) {
  Problem p;
  p.W = random_compliance(3, random);
  p.W.block<1, 2>(0, 1) *= 0.3;  // less of the press turns into slip, so that some contacts stick
  p.W.block<2, 1>(1, 0) *= 0.3;
  p.delta_free = random.matrix(3, 1);
  p.laws = {{LawKind::unilateral, 3}, {LawKind::disk_first, mu, 0, 0}, {LawKind::disk_second, mu, 0, 0}};
  return p;
}

Problem needle_problem(Random& random, int points, double spacing, double element, double stiffness) {
  constexpr int kRows = 4;
  constexpr double kLength = 0.1, kTissue = 1e-3;  // m, m/N: of a point in tissue
  const int n = kRows * points;
  Problem p;
  p.W.setZero(n, n);
  for (int a = 0; a < points; ++a)
    for (int b = 0; b < points; ++b) {
      const double s = 0.02 + spacing * std::min(a, b), t = 0.02 + spacing * std::max(a, b);
      const double apart = (t - s) / element;
      const double tissue = kTissue * std::exp(-apart * apart);
      const double beam = s * s * (3 * t - s) / (2 * kLength * kLength * kLength);  // of a clamped beam, 1 at its end
      for (int k = 0; k < kRows; ++k)
        p.W(kRows * a + k, kRows * b + k) = (k < 3 ? tissue : 0.1 * tissue) + kTissue / stiffness * (k < 2 ? beam : s);
    }
  p.delta_free = random.matrix(n, 1, 1e-5);
  for (int a = 0; a < points; ++a) {
    for (int k = 0; k < 2; ++k) p.laws.push_back({.kind = LawKind::bilateral, .compliance = 0.1 * kTissue});
    p.laws.push_back({LawKind::friction, random.uniform(0.001, 0.05), random.index(2) * random.uniform(0, 5)});
    p.laws.push_back({LawKind::friction, random.uniform(0.001, 0.01)});
    p.delta_free[kRows * a + 2] += random.uniform(0, 4e-5);
  }
  return p;
}

}  // namespace acus
