// SPDX-License-Identifier: GPL-3.0-or-later
// Neither method allocates, on problems that need all of their parts.
#include <doctest/doctest.h>

#include "tests/study/bench/allocation_count.h"
#include "tests/laws/law_problems.h"

namespace acus {
namespace {

Problem contacts_and_points(Random& random) {
  Problem p = needle_problem(random, 90, 1e-3, 10e-3, 1e8);
  const int rows = p.rows();
  for (int c = 0; c < 3; ++c) append_contact(p, random);
  const MatrixX points = p.W;
  p.W = 1e-4 * random_compliance(p.rows(), random);
  p.W.topLeftCorner(rows, rows) += points;
  p.delta_free.conservativeResize(p.rows());
  p.delta_free.tail(9) = random.matrix(9, 1, 1e-4);
  return p;
}

TEST_CASE("neither method allocates") {
  Random random(1);
  for (const Problem& p : {needle_problem(random, 100, 1e-3, 10e-3, 1e8), contacts_and_points(random)}) {
    const auto n = static_cast<std::size_t>(p.rows());
    ConstraintSolver solver(p.rows());
    for (const LawMethod method : kBothMethods) {
      VectorX lambda = VectorX::Zero(p.rows()), delta = lambda;
      SolverResult result;
      int allocations = -1;
      {
        const AllocationCount count;
        result = solver.solve(method, p.W, p.laws, {p.delta_free.data(), n}, 1000, 1e-9, {lambda.data(), n},
                              {delta.data(), n});
        allocations = count.value();
      }
      CHECK(allocations == 0);
      CHECK(result.converged);
    }
  }
}

}  // namespace
}  // namespace acus
