// SPDX-License-Identifier: GPL-3.0-or-later
// Paths outlive the needle that cut them: through an old mouth from either end, beside it, with other spacings, and
// more of them than there is room for.
#include <doctest/doctest.h>

#include <numbers>

#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kSpeed = 0.03;  // m/s

double steady_force(const Bench& bench, int needle, double cutting) {
  const Scene& scene = bench.simulation().scene();
  const Interaction& law = scene.tissue.regions[0].interaction;
  const double d = scene.needles[static_cast<std::size_t>(needle)].outer_diameter;
  return cutting + std::numbers::pi * d * law.friction_dynamic * *law.pressure * bench.needle(needle).inserted_depth;
}

int path_count(const Bench& bench) {
  Matrix3X points(3, bench.simulation().path_capacity());
  int count = 0;
  for (int i = 0; i < Simulation::max_paths(); ++i)
    if (bench.simulation().path_positions(i, points) > 0) ++count;
  return count;
}

Vector3 path_end(const Bench& bench, int path) {
  Matrix3X points(3, bench.simulation().path_capacity());
  return points.col(bench.simulation().path_positions(path, points) - 1);
}

// A slab that a needle goes through; a second one waits below.
Scene slab_scene() {
  Scene scene = block_scene(0.03);
  scene.needles = {needle_at({0.003, 0.002, 0.015}, 0.005), needle_at({0.003, 0.002, -0.015}, 0.02, false)};
  scene.needles[1].name = "from below";
  return scene;
}

}  // namespace

TEST_CASE("a mouth where a needle came out lets another in, without puncture and without cutting" *
          doctest::test_suite("gate")) {
  Bench bench(slab_scene());
  bench.push(0, 0.05, kSpeed);
  REQUIRE(bench.events(EventKind::exit).size() == 1);
  bench.push(0, -0.05, kSpeed);
  bench.wait(0.5);
  REQUIRE(bench.events(EventKind::withdrawal).size() == 1);

  const Vector3 aside = path_end(bench, 0) - bench.needle(1).tip_position;
  bench.move(1, {aside.x(), aside.y(), 0}, kSpeed);
  double largest = 0;
  bench.each_tick = [&] { largest = std::max(largest, bench.needle(1).cutting_force.norm()); };
  bench.push(1, 0.045, kSpeed);
  CHECK(bench.events(EventKind::puncture, 1).empty());
  CHECK(bench.events(EventKind::reentry, 1).size() == 1);
  CHECK(bench.needle(1).inserted_depth == doctest::Approx(0.025).epsilon(0.05).scale(0));
  CHECK(largest < 1e-9);
  CHECK(bench.resistance(1) == doctest::Approx(steady_force(bench, 1, 0)).epsilon(5e-5).scale(0));

  bench.push(1, 0.015, kSpeed);  // out at the mouth that the first one cut
  CHECK(bench.events(EventKind::exit, 1).size() == 1);
  CHECK(bench.needle(1).phase == Phase::through);
  CHECK(largest < 1e-9);
  bench.push(1, -0.07, kSpeed);
  bench.wait(0.5);
  CHECK(bench.events(EventKind::withdrawal, 1).size() == 1);

  // And from above again, the path turned round once more.
  bench.push(0, 0.05, kSpeed);
  CHECK(bench.events(EventKind::puncture, 0).size() == 1);
  CHECK(bench.events(EventKind::exit, 0).size() == 2);
  CHECK(bench.needle(0).phase == Phase::through);
  bench.push(0, -0.05, kSpeed);
  bench.wait(0.5);
  CHECK(bench.events(EventKind::withdrawal, 0).size() == 2);
  CHECK(path_count(bench) == 1);
  CHECK(bench.tissue_displacement() < 1e-9);
  CHECK(bench.finite());
}

TEST_CASE("a needle that enters 3 mm beside an old mouth makes its own path") {
  Bench bench(block_scene());
  bench.push(0, 0.03, kSpeed);
  bench.push(0, -0.03, kSpeed);
  bench.move(0, {3e-3, 0, 0}, kSpeed);
  bench.wait(0.3);
  bench.push(0, 0.03, kSpeed);
  CHECK(bench.events(EventKind::puncture).size() == 2);
  CHECK(bench.events(EventKind::reentry).empty());
  CHECK(path_count(bench) == 2);
  const double f_c = bench.simulation().scene().tissue.regions[0].interaction.cutting_force;
  CHECK(bench.resistance() == doctest::Approx(steady_force(bench, 0, f_c)).epsilon(1e-4).scale(0));
}

TEST_CASE("needles of different spacing go on in each other's paths" * doctest::test_suite("gate")) {
  for (const double first_spacing : {2e-3, 8e-3}) {
    CAPTURE(first_spacing);
    Scene scene = block_scene(0.08);
    scene.needle_contact.enabled = false;  // one stands in the other
    scene.needles.push_back(scene.needles[0]);
    scene.needles[0].constraint_spacing = first_spacing;
    scene.needles[1].name = "second";
    scene.needles[1].constraint_spacing = 4e-3;
    scene.needles[1].base.position.z() += 0.06;
    const double f_c = scene.tissue.regions[0].interaction.cutting_force;
    Bench bench(scene);
    bench.push(0, 0.035, kSpeed);
    bench.push(0, -0.06, kSpeed);
    bench.move(0, {0.02, 0, 0}, 0.1);  // out of the way
    bench.wait(0.3);
    bench.push(1, 0.085, kSpeed);  // 5 mm short of the old end
    CHECK(bench.events(EventKind::puncture, 1).empty());
    CHECK(bench.needle(1).cutting_force.norm() < 1e-9);
    CHECK(bench.resistance(1) == doctest::Approx(steady_force(bench, 1, 0)).epsilon(5e-5).scale(0));
    bench.push(1, 0.025, kSpeed);  // and past it
    CHECK(bench.resistance(1) == doctest::Approx(steady_force(bench, 1, f_c)).epsilon(7e-6).scale(0));
    bench.push(1, -0.12, kSpeed);
    bench.wait(0.5);
    CHECK(bench.events(EventKind::withdrawal, 1).size() == 1);
    CHECK(path_count(bench) == 1);
    CHECK(bench.flags() == 0);
    CHECK(bench.tissue_displacement() < 1e-9);
  }
}

TEST_CASE("a needle goes on in a path of a much smaller spacing than its own, and comes out" *
          doctest::test_suite("gate")) {
  // A path keeps the spacing of the needle that cut it first. A short needle with a fine spacing begins one; a long
  // needle goes on in it for more vertices than either would have at its own spacing.
  Scene scene = block_scene(0.08);
  scene.needle_contact.enabled = false;  // one stands in the other
  scene.needles.push_back(scene.needles[0]);
  Needle& fine = scene.needles[0];
  fine.length = 0.01;
  fine.constraint_spacing = 0.5e-3;
  fine.base.position.z() -= 0.09;
  Needle& coarse = scene.needles[1];
  coarse.name = "coarse";
  coarse.constraint_spacing = 0.01;
  coarse.base.position.z() += 0.02;
  Bench bench(scene);
  bench.push(0, 0.01, kSpeed);
  REQUIRE(bench.events(EventKind::puncture, 0).size() == 1);
  bench.push(0, -0.03, kSpeed);
  bench.move(0, {0.02, 0, 0}, 0.1);
  bench.wait(0.3);
  bench.push(1, 0.09, kSpeed);  // 65 mm deep
  CHECK(bench.events(EventKind::puncture, 1).empty());
  CHECK(bench.flags() == 0);  // rows and vertices all fit
  CHECK(bench.needle(1).inserted_depth == doctest::Approx(0.065).epsilon(0.02).scale(0));
  const double f_c = scene.tissue.regions[0].interaction.cutting_force;
  CHECK(bench.resistance(1) == doctest::Approx(steady_force(bench, 1, f_c)).epsilon(1e-4));
  bench.push(1, -0.1, kSpeed);
  bench.wait(0.5);
  CHECK(bench.events(EventKind::withdrawal, 1).size() == 1);
  CHECK(bench.tissue_displacement() < 1e-9);
  CHECK(bench.finite());
}

}  // namespace acus::test
