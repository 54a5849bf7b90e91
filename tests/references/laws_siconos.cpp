// SPDX-License-Identifier: GPL-3.0-or-later
// The laws' solvers against those of Siconos, on problems that are too large to enumerate: up to 120 rows of every
// one-row law by Lemke's pivoting, needles in tissue among them, and systems of contacts with Coulomb friction by
// nonsmooth Gauss-Seidel.
//
// Sources
//   R. W. Cottle, J.-S. Pang, R. E. Stone, "The Linear Complementarity Problem" (1992), sec. 4.4: Lemke's method.
//   V. Acary, B. Brogliato, "Numerical Methods for Nonsmooth Dynamical Systems" (2008), ch. 13: friction-contact.
//   Both as in Siconos, see siconos_problems.h.
#include <doctest/doctest.h>

#include "tests/references/figure.h"
#include "tests/references/siconos_problems.h"

namespace acus {
namespace {

double apart(const VectorX& a, const VectorX& b) { return (a - b).norm() / (1 + b.norm()); }

// The largest distance of both methods' forces from Siconos', relative; counts what Siconos could not solve.
struct Comparison {
  double worst[2] = {0, 0};
  int unsolved = 0;

  void add(const Problem& p, const std::optional<VectorX>& reference) {
    if (!reference) {
      ++unsolved;
      return;
    }
    for (int m = 0; m < 2; ++m)
      worst[m] = std::max(worst[m], apart(solve(p, kBothMethods[m], {200000, 1e-12}).lambda, *reference));
  }
};

void check(const char* what, const Comparison& c, double tolerance, int allowed_unsolved = 0) {
  CHECK(agrees(std::string(what) + ", sweeps against Siconos", 0, c.worst[0], tolerance));
  CHECK(agrees(std::string(what) + ", direct against Siconos", 0, c.worst[1], tolerance));
  CHECK(agrees(std::string(what) + ", not solved by Siconos", 0, c.unsolved, allowed_unsolved));
}

TEST_CASE("every one-row law, to 120 rows: Lemke's pivoting finds the same forces") {
  Random random(21);
  Comparison c;
  for (const int n : {10, 30, 60, 120})
    for (int repeat = 0; repeat < 5; ++repeat) {
      Problem p;
      p.W = random_compliance(n, random);
      p.delta_free = random.matrix(n, 1);
      for (int i = 0; i < n; ++i) p.laws.push_back(random_law(random));
      c.add(p, solve_relay(p));
    }
  check("one-row laws, 10 to 120 rows", c, 1e-9, 2);
}

TEST_CASE("needles in tissue, 5 to 20 points: Lemke's pivoting finds the same forces") {
  Random random(22);
  Comparison c;
  for (const int points : {5, 10, 20})
    for (const double stiffness : {1.0, 1e4, 1e8}) {
      const Problem p = needle_problem(random, points, 4e-3, 10e-3, stiffness);
      c.add(p, solve_relay(p));
    }
  check("needle in tissue, 20 to 80 rows", c, 1e-8);
}

// Contacts in front, rigid bilateral rows behind.
Problem contacts_and_bilateral(int contacts, int bilateral, Random& random) {
  Problem p;
  const int n = 3 * contacts + bilateral;
  p.W = random_compliance(n, random) / n + MatrixX::Identity(n, n);  // weakly coupled, so that the answer is unique
  p.delta_free = random.matrix(n, 1);
  for (int i = 0; i < contacts; ++i) {
    const double mu = random.uniform(0.1, 0.7);
    p.laws.push_back({LawKind::unilateral, kInfinite});
    p.laws.push_back({.kind = LawKind::disk_first, .limit = mu, .normal_row = 3 * i});
    p.laws.push_back({.kind = LawKind::disk_second, .limit = mu, .normal_row = 3 * i});
    p.delta_free[3 * i] -= 0.5;  // most of them touch
  }
  p.laws.insert(p.laws.end(), static_cast<std::size_t>(bilateral), Law{LawKind::bilateral});
  return p;
}

TEST_CASE("contacts with Coulomb friction, to 20 of them among bilateral rows: Siconos finds the same forces") {
  Random random(23);
  Comparison c;
  for (const int contacts : {1, 2, 5, 20})
    for (int repeat = 0; repeat < 10; ++repeat) {
      const Problem p = contacts_and_bilateral(contacts, 2 * contacts, random);
      c.add(p, solve_contacts(p));
    }
  check("contacts with friction, 1 to 20", c, 1e-9);
}

}  // namespace
}  // namespace acus
