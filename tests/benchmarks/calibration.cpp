// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/bench/calibration.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/benchmarks/small_scene.h"

namespace acus {
namespace {

TEST_CASE("the calibration solves with the matrix of the tick, whatever the ordering") {
  const Simulation simulation(test::small_scene());
  const SparseMatrix lower = tick_matrix(simulation);
  REQUIRE(lower.rows() == 3 * simulation.costs().free_nodes);
  const VectorX ones = VectorX::Ones(lower.rows());
  for (const std::vector<int>& order : {simulation_order(lower), std::vector<int>{}}) {
    CholmodSolve solve(lower, order);
    solve.run();
    const VectorX left = lower.selfadjointView<Eigen::Lower>() * solve.solution();
    CHECK((left - ones).norm() < 1e-9 * ones.norm());
    CHECK(solve.ordering_name() != std::string("another ordering"));
  }
}

TEST_CASE("the simulation's order is told by its name, and every unknown has its place") {
  const Simulation simulation(test::small_scene());
  const SparseMatrix lower = tick_matrix(simulation);
  std::vector<int> order = simulation_order(lower);
  CHECK(CholmodSolve(lower, order).ordering_name() == std::string("the simulation's"));
  CHECK(CholmodSolve(lower).ordering_name() != std::string("the simulation's"));
  std::sort(order.begin(), order.end());
  for (int i = 0; i < lower.rows(); ++i) CHECK(order[static_cast<std::size_t>(i)] == i);
}

TEST_CASE("the matrix of the tick holds masses over h squared") {
  Scene stiff_time = test::small_scene();
  stiff_time.rate = 1e5;
  const Simulation simulation(stiff_time);
  const SparseMatrix lower = tick_matrix(simulation);
  double free_mass = 0;  // kg
  for (int i = 0; i < lower.rows(); i += 3) free_mass += lower.coeff(i, i) / 1e10;
  // A block of 0.216 kg whose bottom layer of cells lets go of a third of its own to the fixed nodes, about.
  CHECK(free_mass > 0.15);
  CHECK(free_mass < 0.216);
}

TEST_CASE("no matrix is factorised that is not positive definite") {
  SparseMatrix lower(2, 2);
  lower.insert(0, 0) = 1;
  lower.insert(1, 1) = -1;
  lower.makeCompressed();
  CHECK_THROWS_AS(CholmodSolve{lower}, std::runtime_error);
}

}  // namespace
}  // namespace acus
