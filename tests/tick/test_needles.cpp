// SPDX-License-Identifier: GPL-3.0-or-later
// Needles other than the straight flexible one.
#include <doctest/doctest.h>

#include "tests/support/places.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

Scene default_scene() {
  Scene scene = read_scene(source_path("scenes/insertion_pullback.yaml"));
  scene.tissue.box.cells = {6, 6, 6};
  return scene;
}

}  // namespace

TEST_CASE("in the default scene a rigid needle feels along its axis what a flexible one does" *
          doctest::test_suite("gate")) {
  Scene scene = default_scene();
  Bench flexible(scene);
  scene.needles[0].rung = NeedleRung::rigid;
  Bench rigid(scene);
  const auto compare = [&](double by) {
    flexible.push(0, by, 0.02);
    rigid.push(0, by, 0.02);
    CAPTURE(rigid.needle().inserted_depth);
    CHECK(rigid.needle().inserted_depth == doctest::Approx(flexible.needle().inserted_depth).epsilon(3e-4).scale(0));
    CHECK(rigid.resistance() == doctest::Approx(flexible.resistance()).epsilon(4e-4).scale(0));
  };
  compare(0.03);
  compare(0.02);
  compare(0.02);
  compare(-0.02);
  compare(-0.02);
  compare(0.01);
  CHECK(flexible.flags() == 0);
  CHECK((rigid.flags() & ~std::uint32_t{kLawsNotConverged}) == 0);
}

TEST_CASE("a rigid needle goes in, through and out, and the tissue comes to rest" * doctest::test_suite("gate")) {
  Scene scene = block_scene(0.03);
  scene.needles[0].rung = NeedleRung::rigid;
  Bench bench(scene);
  bench.push(0, 0.05, 0.03);
  CHECK(bench.needle().phase == Phase::through);
  bench.push(0, -0.05, 0.03);
  bench.wait(1);
  CHECK(bench.events(EventKind::puncture).size() == 1);
  CHECK(bench.events(EventKind::exit).size() == 1);
  CHECK(bench.events(EventKind::reentry).size() == 1);
  CHECK(bench.events(EventKind::withdrawal).size() == 1);
  CHECK(bench.tissue_displacement() < 1e-9);
  CHECK(bench.flags() == 0);
}

TEST_CASE("a curved needle goes in, stays finite and comes out" * doctest::test_suite("gate")) {
  for (const NeedleRung rung : {NeedleRung::flexible, NeedleRung::rigid}) {
    CAPTURE(static_cast<int>(rung));
    Scene scene = block_scene();
    Needle& needle = scene.needles[0];
    needle.rung = rung;
    needle.curvature = 10;
    needle.curved_length = 0.03;
    needle.base.position.z() += 0.005;
    Bench bench(scene);
    bench.push(0, 0.045, 0.03);
    CHECK(bench.needle().phase == Phase::inside);
    CHECK(bench.needle().inserted_depth > 0.02);
    CHECK(bench.needle().lateral_force.norm() > 0.01);  // the straightened arc presses on its path
    bench.push(0, -0.06, 0.03);
    bench.wait(1);
    CHECK(bench.events(EventKind::withdrawal).size() == 1);
    CHECK(bench.tissue_displacement() < 1e-9);
    CHECK(bench.finite());
    CHECK((bench.flags() & kNotFinite) == 0);
  }
}

}  // namespace acus::test
