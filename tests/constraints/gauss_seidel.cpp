// SPDX-License-Identifier: GPL-3.0-or-later
// The solver against an oracle that tries every combination of branches; its residual, bounds and determinism.
#include "server/constraints/gauss_seidel.h"

#include <doctest/doctest.h>

#include <cstring>
#include <limits>
#include <optional>

#include "tests/support/random.h"

namespace acus {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

struct Problem {
  MatrixX W;
  std::vector<Law> laws;
  VectorX delta_free;

  int rows() const { return static_cast<int>(laws.size()); }
};

struct Answer {
  VectorX lambda, delta;
  SolverResult result;
};

Answer solve(const Problem& p, int max_sweeps = 100000, double tolerance = 1e-11, const VectorX& start = {}) {
  Answer a;
  a.lambda = start.size() > 0 ? start : VectorX::Zero(p.rows());
  a.delta = VectorX::Zero(p.rows());
  const auto n = static_cast<std::size_t>(p.rows());
  GaussSeidel solver(p.rows() + 3);
  a.result = solver.solve(p.W, p.laws, {p.delta_free.data(), n}, max_sweeps, tolerance, {a.lambda.data(), n},
                          {a.delta.data(), n});
  return a;
}

MatrixX random_compliance(int n, Random& random) {
  const MatrixX g = random.matrix(n, n);
  return g * g.transpose() + 0.05 * MatrixX::Identity(n, n);
}

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

bool on_graph(const Law& law, double lambda, double delta) {
  constexpr double kSlack = 1e-9;
  switch (law.kind) {
    case LawKind::bilateral:
      return std::abs(delta + law.compliance * lambda) < kSlack;
    case LawKind::unilateral:
      return lambda > -kSlack && lambda < law.limit + kSlack && (delta < kSlack || lambda < kSlack) &&
             (delta > -kSlack || lambda > law.limit - kSlack);
    default:
      if (std::abs(delta) < kSlack) return std::abs(lambda) < law.limit + kSlack;
      return std::abs(lambda + std::copysign(law.limit, delta) + law.viscosity * delta) < kSlack;
  }
}

// Solves the linear system of every combination of branches and keeps the one that lies on all graphs.
std::optional<VectorX> enumerate(const Problem& p) {
  const int n = p.rows();
  std::vector<std::vector<Branch>> choices;
  std::size_t combinations = 1;
  for (int i = 0; i < n; ++i) {
    choices.push_back(branches(p.laws[static_cast<std::size_t>(i)]));
    combinations *= choices.back().size();
  }
  for (std::size_t c = 0; c < combinations; ++c) {
    MatrixX system(n, n);
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
    const VectorX lambda = system.fullPivLu().solve(rhs);
    if (!lambda.allFinite()) continue;
    const VectorX delta = p.W * lambda + p.delta_free;
    bool all = true;
    for (int i = 0; i < n && all; ++i) all = on_graph(p.laws[static_cast<std::size_t>(i)], lambda[i], delta[i]);
    if (all) return lambda;
  }
  return std::nullopt;
}

Law random_law(Random& random) {
  switch (random.index(7)) {
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
      return {LawKind::friction, random.uniform(0, 1), random.uniform(0, 5)};
    default:
      return {LawKind::friction, random.uniform(0, 1)};
  }
}

TEST_CASE("the solver finds the one point where all graphs meet their lines") {
  Random random(1);
  for (int repeat = 0; repeat < 400; ++repeat) {
    Problem p;
    const int n = 1 + random.index(6);
    p.W = random_compliance(n, random);
    p.delta_free = random.matrix(n, 1);
    for (int i = 0; i < n; ++i) p.laws.push_back(random_law(random));
    const std::optional<VectorX> oracle = enumerate(p);
    REQUIRE(oracle);
    const Answer answer = solve(p);
    CAPTURE(repeat);
    // Bilateral rows carry the solver's regularisation; nothing else may be left.
    const double give = GaussSeidel::kRegularization * p.W.diagonal().maxCoeff() / p.W.diagonal().minCoeff();
    CHECK(answer.result.residual < 2e-11 + give * answer.lambda.cwiseAbs().maxCoeff());
    CHECK((answer.lambda - *oracle).norm() < 1e-6 * (1 + oracle->norm()));
  }
}

// A unilateral row 0 and its two friction rows 1 and 2 on random compliances.
Problem contact_problem(Random& random, double mu) {
  Problem p;
  p.W = random_compliance(3, random);
  p.W.block<1, 2>(0, 1) *= 0.3;  // less of the press turns into slip, so that some contacts stick
  p.W.block<2, 1>(1, 0) *= 0.3;
  p.delta_free = random.matrix(3, 1);
  p.laws = {{LawKind::unilateral, 3}, {LawKind::disk_first, mu, 0, 0}, {LawKind::disk_second, mu, 0, 0}};
  return p;
}

TEST_CASE("disk friction obeys Coulomb's cone") {
  Random random(2);
  int sticking = 0, sliding = 0;
  for (int repeat = 0; repeat < 200; ++repeat) {
    Problem p = contact_problem(random, 0.3);
    p.delta_free[0] = -std::abs(p.delta_free[0]);
    if (repeat % 2 == 0) p.delta_free.tail<2>() *= 0.01;
    const Answer a = solve(p);
    REQUIRE(a.result.converged);
    CHECK(on_graph(p.laws[0], a.lambda[0], a.delta[0]));
    const double radius = 0.3 * a.lambda[0];
    const Eigen::Vector2d force = a.lambda.tail<2>(), slip = a.delta.tail<2>();
    CHECK(force.norm() <= radius + 1e-9);
    if (force.norm() < radius - 1e-6) {
      CHECK(slip.norm() < 1e-8);
      ++sticking;
    } else if (radius > 1e-3) {
      CHECK(std::abs(force.dot(slip) + force.norm() * slip.norm()) < 1e-8);
      ++sliding;
    }
  }
  CHECK(sticking > 10);
  CHECK(sliding > 10);
}

TEST_CASE("disk friction does not depend on the axes across the normal") {
  Random random(3);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const Problem p = contact_problem(random, 0.3);
    Matrix3 turn = Matrix3::Identity();
    turn.bottomRightCorner<2, 2>() = Eigen::Rotation2Dd(random.uniform(-3, 3)).toRotationMatrix();
    Problem turned = p;
    turned.W = turn * p.W * turn.transpose();
    turned.delta_free = turn * p.delta_free;
    CHECK((solve(turned).lambda - turn * solve(p).lambda).norm() < 1e-8);
  }
}

TEST_CASE("disks keep to their normal row when bilateral rows stand in between") {
  Random random(4);
  Problem p;
  p.W = random_compliance(5, random);
  p.delta_free = VectorX(5);
  p.delta_free << 0.1, -1, 0.2, 0.4, -0.3;
  p.laws = {{LawKind::bilateral},
            {LawKind::unilateral, 3},
            {LawKind::bilateral},
            {LawKind::disk_first, 0.2, 0, 1},
            {LawKind::disk_second, 0.2, 0, 1}};
  const Answer a = solve(p, 100000, 1e-8);
  REQUIRE(a.result.converged);
  CHECK(a.lambda[1] > 0);
  CHECK(a.lambda.tail<2>().norm() == doctest::Approx(0.2 * a.lambda[1]).epsilon(1e-6));
  CHECK(std::abs(a.delta[0]) < 1e-7);
  CHECK(std::abs(a.delta[2]) < 1e-7);
}

// Rows 0 to 3 twice over: W has rank 4 of 8.
Problem doubled_problem(Random& random) {
  const MatrixX w = random_compliance(4, random);
  const VectorX free = random.matrix(4, 1);
  Problem p;
  p.W.resize(8, 8);
  p.W << w, w, w, w;
  p.delta_free.resize(8);
  p.delta_free << free, free;
  for (int copy = 0; copy < 2; ++copy)
    for (const Law& law : {Law{LawKind::bilateral}, Law{LawKind::unilateral, 2.0}, Law{LawKind::friction, 0.5},
                           Law{.kind = LawKind::bilateral}})
      p.laws.push_back(law);
  return p;
}

TEST_CASE("rows that say the same twice stay bounded and share the force") {
  Random random(5);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const Problem p = doubled_problem(random);
    const Answer a = solve(p, 1000, 1e-6);
    REQUIRE(a.lambda.allFinite());
    CHECK(a.lambda.cwiseAbs().maxCoeff() < 1e3);
    CHECK(a.result.converged);
    CHECK(std::abs(a.delta[0]) < 1e-5);
    CHECK(std::abs(a.delta[3]) < 1e-5);
  }
}

TEST_CASE("a capped or frictional row along a bilateral one stays bounded") {
  Random random(6);
  for (const Law& law : {Law{LawKind::unilateral, 2.0}, Law{LawKind::unilateral, kInfinite},
                         Law{LawKind::friction, 0.5}, Law{LawKind::friction, 0.5, 3.0}}) {
    const MatrixX w = random_compliance(2, random);
    Problem p;
    p.W.resize(3, 3);
    p.W << w, w.col(1), w.row(1), w(1, 1);
    p.delta_free = Vector3(0.3, -0.2, -0.2);
    p.laws = {{LawKind::bilateral}, {LawKind::bilateral}, law};
    const Answer a = solve(p, 1000, 1e-6);
    CHECK(a.lambda.allFinite());
    CHECK(a.lambda.cwiseAbs().maxCoeff() < 1e3);
    CHECK(std::abs(a.delta[0]) < 1e-5);
    CHECK(std::abs(a.delta[1]) < 1e-5);
  }
}

TEST_CASE("two contacts in the same place carry together what one would") {
  Problem p;
  p.W = MatrixX::Constant(2, 2, 0.5);
  p.delta_free = Eigen::Vector2d(-1, -1);
  p.laws = {{LawKind::unilateral, kInfinite}, {LawKind::unilateral, kInfinite}};
  const Answer a = solve(p);
  CHECK(a.result.converged);
  CHECK(a.lambda.sum() == doctest::Approx(2));
}

TEST_CASE("displacements and residual are those of the forces returned, converged or not") {
  Random random(7);
  for (const int max_sweeps : {0, 1, 3, 10000}) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      Problem p = contact_problem(random, 0.3);
      p.laws.insert(p.laws.end(), {{LawKind::bilateral}, {LawKind::friction, 0.2}, {LawKind::unilateral, 1.0}});
      p.W = random_compliance(6, random);
      p.delta_free = random.matrix(6, 1);
      const Answer a = solve(p, max_sweeps, 1e-10, random.matrix(6, 1));
      CHECK((a.delta - p.W * a.lambda - p.delta_free).norm() < 1e-12);
      const std::span<const double> lambda(a.lambda.data(), 6), delta(a.delta.data(), 6);
      CHECK(a.result.residual == law_residual(p.W, p.laws, lambda, delta));
      CHECK(a.result.converged == (a.result.residual <= 1e-10));
      CHECK(a.result.sweeps <= max_sweeps);
      if (max_sweeps == 10000) CHECK(a.result.residual < 1e-6);
    }
  }
}

TEST_CASE("the residual is the force by which the worst row is off its graph") {
  const MatrixX W = MatrixX::Identity(3, 3);
  const std::vector<Law> laws{{LawKind::bilateral}, {LawKind::unilateral, 2}, {LawKind::friction, 1}};
  const auto residual = [&](const Vector3& lambda, const Vector3& delta) {
    return law_residual(W, laws, {lambda.data(), 3}, {delta.data(), 3});
  };
  CHECK(residual({7, 0, 0.5}, {0, 1, 0}) == 0);
  CHECK(residual({7, 2, -1}, {0, -1, 1}) == 0);
  CHECK(residual({7, 0, 0}, {0.5, 0, 0}) == doctest::Approx(0.5));     // bilateral apart
  CHECK(residual({0, 0.25, 0}, {0, 1, 0}) == doctest::Approx(0.25));   // pulls while open
  CHECK(residual({0, 0, 0}, {0, -0.75, 0}) == doctest::Approx(0.75));  // pierces without force
  CHECK(residual({0, 0, 3}, {0, 0, 0}) == doctest::Approx(2));         // sticks above the threshold
  CHECK(residual({0, 0, 1}, {0, 0, 1}) == doctest::Approx(1));         // pushes along with the slip
}

TEST_CASE("a start at the answer needs no sweep") {
  Random random(8);
  const Problem p = contact_problem(random, 0.3);
  const Answer first = solve(p, 100000, 1e-12);
  CHECK(solve(p, 100000, 1e-9, first.lambda).result.sweeps == 0);
}

TEST_CASE("the same problem gives the same bits, in a solver that has seen others") {
  Random random(9);
  const Problem p = doubled_problem(random), other = contact_problem(random, 0.5);
  GaussSeidel used(12);
  const auto run = [](GaussSeidel& solver, const Problem& problem) {
    VectorX lambda = VectorX::Zero(problem.rows()), delta = lambda;
    const auto n = static_cast<std::size_t>(problem.rows());
    solver.solve(problem.W, problem.laws, {problem.delta_free.data(), n}, 200, 1e-9, {lambda.data(), n},
                 {delta.data(), n});
    return lambda;
  };
  const VectorX first = run(used, p);
  run(used, other);
  const VectorX again = run(used, p);
  GaussSeidel fresh(8);
  const VectorX elsewhere = run(fresh, p);
  CHECK(std::memcmp(first.data(), again.data(), 8 * sizeof(double)) == 0);
  CHECK(std::memcmp(first.data(), elsewhere.data(), 8 * sizeof(double)) == 0);
}

TEST_CASE("W may be larger than the rows in use, and there may be none") {
  Random random(10);
  Problem p = contact_problem(random, 0.3);
  const Answer tight = solve(p);
  MatrixX large = MatrixX::Constant(9, 9, 1e9);
  large.topLeftCorner(3, 3) = p.W;
  p.W = large;
  VectorX lambda = VectorX::Zero(3), delta = lambda;
  GaussSeidel solver(9);
  solver.solve(p.W, p.laws, {p.delta_free.data(), 3}, 100000, 1e-11, {lambda.data(), 3}, {delta.data(), 3});
  CHECK((lambda - tight.lambda).norm() < 1e-12);
  const SolverResult none = solver.solve(p.W, {}, {}, 100, 1e-9, {}, {});
  CHECK(none.converged);
  CHECK(none.sweeps == 0);
}

}  // namespace
}  // namespace acus
