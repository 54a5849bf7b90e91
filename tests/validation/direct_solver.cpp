// SPDX-License-Identifier: GPL-3.0-or-later
// The direct solver of the laws against sweeps run to 1e-9 N, in whole scenes: the same forces, exact, in few steps.
#include <doctest/doctest.h>

#include <algorithm>

#include "tests/validation/insertion_run.h"

namespace acus::test {
namespace {

constexpr int kFewSteps = 100;  // sweeps, picks and interior-point iterations of a tick

const std::vector<Leg> kInAndBack{{0.06, 0.15, 0.02}, {0.055, 0.1, 0.02}};

Scene block_of(std::array<int, 3> cells) {
  Scene scene = default_scene();
  scene.tissue.box.cells = cells;
  return scene;
}

Scene solved_by(Scene scene, LawMethod solver, int max_steps) {
  scene.laws = {solver, max_steps, 1e-9};
  return scene;
}

// Points closer than elements, and a steel needle in soft tissue: rows that depend on each other most.
Scene stiff_scene() {
  Scene scene = block_of({10, 10, 10});
  scene.needles[0].material.young_modulus = 200e9;
  scene.needles[0].constraint_spacing = 2e-3;
  Region& tissue = scene.tissue.regions[0];
  tissue.material.young_modulus = 2e3;
  tissue.interaction.puncture_force = 0.2;
  tissue.interaction.cutting_force = 0.1;
  return scene;
}

Scene rigid_scene() {
  Scene scene = block_of({5, 5, 5});
  scene.needles[0].rung = NeedleRung::rigid;
  return scene;
}

void check_against_sweeps(const Scene& scene) {
  InsertionRun direct(solved_by(scene, LawMethod::direct, kFewSteps));
  InsertionRun swept(solved_by(scene, LawMethod::gauss_seidel, 100000));
  direct.run(kInAndBack);
  swept.run(kInAndBack);
  REQUIRE(direct.samples().size() == swept.samples().size());
  double peak = 1, difference = 0, residual = 0;
  std::uint32_t flags = 0, swept_flags = 0;
  int rows = 0;
  for (std::size_t i = 0; i < direct.samples().size(); ++i) {
    const TickReport &a = direct.samples()[i].report, &b = swept.samples()[i].report;
    flags |= a.flags;
    swept_flags |= b.flags;
    rows = std::max(rows, a.rows);
    residual = std::max(residual, a.residual);
    peak = std::max(peak, b.needles[0].base_force.norm());
    difference = std::max(difference, (a.needles[0].base_force - b.needles[0].base_force).norm());
  }
  MESSAGE(rows << " rows, largest force " << peak << " N, difference " << difference << " N, residual " << residual
               << " N");
  REQUIRE(direct.find(EventKind::puncture) != nullptr);
  CHECK((flags & (kSolverFellBack | kLawsNotConverged)) == 0);
  CHECK((swept_flags & kLawsNotConverged) == 0);
  CHECK(residual < 1e-10 * peak);
  CHECK(difference < 5e-8 * peak);
}

TEST_CASE("direct and sweeps: the first scene in coarse elements") { check_against_sweeps(block_of({5, 5, 5})); }

TEST_CASE("direct and sweeps: points at 2 mm on elements of 10 mm, steel in tissue of 2 kPa") {
  check_against_sweeps(stiff_scene());
}

TEST_CASE("direct and sweeps: a rigid needle") { check_against_sweeps(rigid_scene()); }

}  // namespace
}  // namespace acus::test
