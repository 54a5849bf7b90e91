// SPDX-License-Identifier: GPL-3.0-or-later
// The direct method where Gauss-Seidel fails: stiffness ratios of 1e8, rows that are nearly dependent, points closer
// than elements; from thousands of random problems with contacts to 200 rows. And its fallback and its bounds.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/laws/law_problems.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

// Laws of one row, `contacts` contacts with friction in front, on a given W.
Problem problem_on(const MatrixX& W, int contacts, Random& random) {
  Problem p;
  p.W = (W + W.transpose()) / 2;
  for (int c = 0; c < contacts; ++c) append_contact(p, random);
  while (p.rows() < static_cast<int>(W.rows())) p.laws.push_back(random_law(random));
  p.delta_free = random.matrix(W.rows(), 1);
  return p;
}

// Eigenvalues spread over the given ratio, in directions that mix all rows.
MatrixX spread_compliance(int n, double ratio, Random& random) {
  const MatrixX q = test::orthogonal_factor(random.matrix(n, n));
  VectorX values(n);
  for (double& value : values) value = std::pow(ratio, -random.uniform(0, 1));
  return q * values.asDiagonal() * q.transpose();
}

void check_exact(const Problem& p, const Answer& a) {
  CHECK(a.result.method == LawMethod::direct);
  CHECK_FALSE(a.result.fell_back);
  CHECK(a.result.sweeps == 0);
  CHECK(a.result.residual < 1e-10 * force_scale({a.lambda.data(), static_cast<std::size_t>(p.rows())}));
  CHECK((a.delta - p.W * a.lambda - p.delta_free).norm() < 1e-12 * (1 + p.delta_free.norm()));
}

TEST_CASE("thousands of random problems, contacts among them, end on the graphs of their laws") {
  Random random(1);
  for (int repeat = 0; repeat < 4000; ++repeat) {
    const int contacts = repeat % 2;
    const Problem p = problem_on(random_compliance(4 + random.index(6), random), contacts, random);
    const Answer a = solve(p, LawMethod::direct);
    CAPTURE(repeat);
    check_exact(p, a);
    CHECK(off_graphs(p, a) < 1e-10);
  }
}

TEST_CASE("both methods agree on large problems, the sweeps run to 1e-12") {
  Random random(2);
  for (const int n : {30, 60, 200}) {
    for (int repeat = 0; repeat < 5; ++repeat) {
      const Problem p = problem_on(random_compliance(n, random), repeat % 3, random);
      const Answer direct = solve(p, LawMethod::direct), swept = solve(p, LawMethod::gauss_seidel, {100000, 1e-12});
      check_exact(p, direct);
      CHECK((direct.lambda - swept.lambda).norm() < 1e-8 * (1 + swept.lambda.norm()));
    }
  }
}

TEST_CASE("stiffness ratios of 1e8 between directions cost neither exactness nor steps") {
  Random random(3);
  for (int repeat = 0; repeat < 300; ++repeat) {
    const Problem p = problem_on(spread_compliance(20, 1e8, random), 0, random);
    const Answer a = solve(p, LawMethod::direct);
    check_exact(p, a);
    CHECK(a.result.steps.picks + a.result.steps.iterations < 60);
  }
}

TEST_CASE("stiffness ratios of 1e8 between rows") {
  Random random(4);
  for (int repeat = 0; repeat < 300; ++repeat) {
    VectorX scale(20);
    for (double& s : scale) s = std::pow(1e-4, random.uniform(0, 1));
    Problem p = problem_on(scale.asDiagonal() * random_compliance(20, random) * scale.asDiagonal(), 0, random);
    p.delta_free.array() *= p.W.diagonal().array();
    check_exact(p, solve(p, LawMethod::direct));
  }
}

TEST_CASE("rows that depend on each other") {
  Random random(5);
  for (int repeat = 0; repeat < 300; ++repeat) {
    const MatrixX g = random.matrix(20, 10);
    Problem p = problem_on(g * g.transpose(), 0, random);
    p.delta_free = g * random.matrix(10, 1);  // which no force could meet if it were not
    const Answer a = solve(p, LawMethod::direct);
    CHECK(a.result.residual < 1e-9 * force_scale({a.lambda.data(), 20}));
  }
}

TEST_CASE("points much closer than elements, on needles from soft to all but rigid") {
  Random random(6);
  for (const double stiffness : {1.0, 1e4, 1e8, 1e12}) {
    for (const double spacing : {4e-3, 2e-3, 1e-3}) {
      for (int repeat = 0; repeat < 5; ++repeat) {
        const Problem p = needle_problem(random, 50, spacing, 10e-3, stiffness);
        const Answer a = solve(p, LawMethod::direct);
        check_exact(p, a);
        CHECK(off_graphs(p, a) < 1e-10);
        CHECK(a.result.steps.picks + a.result.steps.iterations < 60);
      }
    }
  }
}

TEST_CASE("a start at the answer needs no step, one beside it few") {
  Random random(7);
  Problem p = problem_on(random_compliance(60, random), 1, random);
  const Answer first = solve(p, LawMethod::direct);
  CHECK(solve(p, LawMethod::direct, {}, first.lambda).result.steps.picks <= 1);
  p.delta_free += 1e-3 * random.matrix(60, 1);
  CHECK(solve(p, LawMethod::direct, {}, first.lambda).result.steps.picks <= 4);
}

TEST_CASE("a needle that slows down: picks end, one at a time where those together go too far") {
  Random random(11);
  int solutions = 0, unended = 0;
  for (const double stiffness : {1.0, 1e2, 1e4})
    for (int repeat = 0; repeat < 10; ++repeat) {
      Problem p = needle_problem(random, 20, 1e-3, 10e-3, stiffness);
      VectorX last = solve(p, LawMethod::direct).lambda;
      for (int tick = 0; tick < 4; ++tick, ++solutions) {
        p.delta_free *= 0.8;
        const Answer a = solve(p, LawMethod::direct, {}, last);
        check_exact(p, a);
        last = a.lambda;
        if (a.result.steps.iterations > 0) ++unended;
      }
    }
  CHECK(unended < solutions / 20);
}

TEST_CASE("where the direct method ends short of the answer Gauss-Seidel goes on, and the result says so") {
  // Disks that do not stand behind their normal row are not the direct method's.
  Random random(8);
  Problem p;
  p.W = random_compliance(5, random);
  p.delta_free = VectorX(5);
  p.delta_free << -1, 0.1, 0.4, -0.3, 0.2;
  p.laws = {{LawKind::unilateral, 3},
            {LawKind::friction, 0.1},
            {LawKind::disk_first, 0.2, 0, 0},
            {LawKind::disk_second, 0.2, 0, 0},
            {LawKind::bilateral}};
  const Answer a = solve(p, LawMethod::direct, {.tolerance = 1e-9});
  CHECK(a.result.fell_back);
  CHECK(a.result.method == LawMethod::gauss_seidel);
  CHECK(a.result.sweeps > 0);
  CHECK(a.result.converged);
  CHECK(off_graphs(p, a) < 3e-9);
}

int steps_of(const SolverResult& result) { return result.sweeps + result.steps.picks + result.steps.iterations; }

TEST_CASE("few steps bound the direct method: it says so, and the best answer so far is what it returns") {
  Random random(9);
  const Problem p = needle_problem(random, 100, 1e-3, 10e-3, 1e8);
  const Answer exact = solve(p, LawMethod::direct, {1000, 1e-9});
  REQUIRE(exact.result.converged);
  CHECK_FALSE(exact.result.capped);
  REQUIRE(steps_of(exact.result) > 3);
  double before = kInfinite;
  for (const int max_steps : {0, 1, 2, 3, 1000}) {
    const Answer a = solve(p, LawMethod::direct, {max_steps, 1e-9});
    CAPTURE(max_steps);
    CHECK(steps_of(a.result) <= max_steps);
    CHECK(a.result.method == LawMethod::direct);
    CHECK_FALSE(a.result.fell_back);
    CHECK(a.result.capped == (max_steps < 1000));
    CHECK(a.result.converged == (max_steps == 1000));
    CHECK(a.lambda.allFinite());
    CHECK(a.result.residual <= before);
    before = a.result.residual;
  }
}

TEST_CASE("a result says that it fell back where sweeps were made, and nowhere else") {
  Random random(10);
  for (int repeat = 0; repeat < 200; ++repeat) {
    const MatrixX g = random.matrix(20, 10);
    Problem p = problem_on(g * g.transpose(), 2, random);
    p.delta_free = g * random.matrix(10, 1);
    const Answer a = solve(p, LawMethod::direct, {1000, 1e-6});
    CHECK(a.result.fell_back == (a.result.sweeps > 0));
    CHECK((a.result.method == LawMethod::gauss_seidel) == a.result.fell_back);
  }
}

}  // namespace
}  // namespace acus
