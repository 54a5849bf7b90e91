// SPDX-License-Identifier: GPL-3.0-or-later
// Action and reaction over the whole world, and the way back to rest.
#include <doctest/doctest.h>

#include "tests/validation/insertion_run.h"

namespace acus::test {

namespace {

// The paper's motion at a speed that keeps the test short.
const std::vector<Leg> kMotion{{0.06, 0.06, 0.1}, {0.03, 0.06, 0.1}, {0.075, 0.06, 0.1}, {-0.005, 0.06, 0.1}};

double largest_displacement(const Simulation& simulation) {
  return (simulation.tissue_positions() - simulation.mesh().nodes).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("rungs refined and exact: base, supports, weight and inertia balance in every tick") {
  Scene scene = default_scene();
  SUBCASE("refined") { scene.tissue.rung = TissueRung::refined; }
  SUBCASE("exact") { scene.tissue.rung = TissueRung::exact; }
  scene.tissue.box.cells = {5, 5, 5};
  scene.gravity = {0.3, 0, -9.81};
  scene.tissue.regions.push_back(scene.tissue.regions[0]);  // damped in another way, at the supports
  scene.tissue.regions[1].name = "below";
  scene.tissue.regions[1].box = Box{.max = {kInfinity, kInfinity, 0}};
  scene.tissue.regions[1].material.rayleigh_stiffness = 0.03;
  InsertionRun insertion(scene);
  double worst = 0, largest = 0;
  int ticks = 0;
  insertion.run({{0.05, 0.1, 0.05}, {-0.005, 0.1}}, [&](const Sample& s) {
    if (++ticks == 1) return;  // there is no tick before the first to speak of
    largest = std::max(largest, s.report.largest_force);
    worst = std::max(worst, s.report.imbalance / s.report.largest_force);
    CHECK((s.report.flags & (kNewtonNotConverged | kNotFinite)) == 0);
  });
  MESSAGE("imbalance / largest force: " << worst << ", largest force " << largest << " N");
  CHECK(insertion.find(EventKind::withdrawal) != nullptr);
  CHECK(largest > 1);
  CHECK(worst < 1e-9);
}

TEST_CASE("rung warped: the imbalance of the default scene stays below 1 % of the largest force") {
  InsertionRun insertion(default_scene());
  double worst = 0, largest = 0;
  insertion.run({{0.06, 0.02, 0.5}, {0.03, 0.02, 0.3}, {0.075, 0.02, 0.5}, {-0.005, 0.03}}, [&](const Sample& s) {
    worst = std::max(worst, s.report.imbalance);
    largest = std::max(largest, s.report.largest_force);
  });
  MESSAGE("imbalance " << worst << " N, largest force " << largest << " N");
  CHECK(worst > 0);
  CHECK(worst < 0.01 * largest);
}

TEST_CASE("the tissue comes back to rest when the needle is out") {
  InsertionRun insertion(default_scene());
  insertion.run(kMotion);
  REQUIRE(insertion.find(EventKind::withdrawal) != nullptr);
  insertion.idle(3);
  CHECK(largest_displacement(insertion.simulation()) < 3e-9);
  CHECK(insertion.last().report.needles[0].base_force.norm() < 1e-9);
}

TEST_CASE("without commands nothing moves") {
  Simulation simulation(default_scene());
  const Matrix3X needle = simulation.needle_positions(0);
  for (int i = 0; i < 200; ++i) simulation.step();
  CHECK(simulation.tissue_positions() == simulation.mesh().nodes);
  CHECK((simulation.needle_positions(0) - needle).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(simulation.report().needles[0].base_force.norm() < 1e-9);
}

}  // namespace acus::test
