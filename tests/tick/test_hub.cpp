// SPDX-License-Identifier: GPL-3.0-or-later
// A needle's hub on the skin. Nothing else bears a force along these needles: they neither cut nor rub.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/engine/math/rotation.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kLength = 0.03, kHub = 6e-3;  // m

Scene hub_scene(double tilt = 0) {
  Scene scene = block_scene();
  Interaction& law = scene.tissue.regions[0].interaction;
  law.cutting_force = law.friction_static = law.friction_dynamic = 0;
  law.puncture_force = 0.1;
  law.friction_contact = 0;
  scene.tissue.regions[0].material.rayleigh_stiffness = 2e-3;  // ends waves
  Needle& needle = scene.needles[0];
  needle.length = kLength;
  needle.hub_diameter = kHub;
  needle.rung = NeedleRung::rigid;
  needle.tip = TipShape::trocar;
  needle.base.orientation = rotation_exp({0, std::numbers::pi / 2 - tilt, 0});
  needle.base.position = Vector3(0.003, 0.002, 0.03) - (kLength + 2e-3) * (needle.base.orientation * Vector3::UnitX());
  return scene;
}

// To where the hub is `deep` (m) below the skin at rest.
void push_to(Bench& bench, double deep, double speed = 0.05) {
  const Vector3 base = bench.needle().base.position;
  bench.push(0, (base.z() - (0.03 - deep)) / -bench.axis().z(), speed);
}

// Of a blunt tip as wide as the hub that nothing punctures (N).
double blunt_force(double deep) {
  Scene scene = hub_scene();
  scene.tissue.regions[0].interaction.puncture_force = kInfinity;
  Needle& needle = scene.needles[0];
  needle.outer_diameter = kHub;
  needle.hub_diameter = 0;
  needle.tip = TipShape::blunt;
  Bench bench(scene);
  bench.push(0, 2e-3 + deep, 0.05);
  bench.wait(1);
  return bench.resistance();
}

}  // namespace

TEST_CASE("a hub meets the skin as a blunt tip of its width does, and tells it once") {
  Bench bench(hub_scene());
  push_to(bench, -0.5e-3);
  CHECK(std::abs(bench.resistance()) < 1e-3);
  CHECK(bench.events(EventKind::hub).empty());
  for (const double deep : {1e-3, 3e-3}) {
    push_to(bench, deep);
    bench.wait(1);
    CAPTURE(deep);
    MESSAGE(bench.resistance(), " N, blunt tip ", blunt_force(deep), " N");
    CHECK(bench.resistance() == doctest::Approx(blunt_force(deep)).epsilon(0.01).scale(0));
    CHECK(bench.needle().inserted_depth == doctest::Approx(kLength).epsilon(0.05));
  }
  REQUIRE(bench.events(EventKind::hub).size() == 1);
  const Event event = bench.events(EventKind::hub)[0];
  CHECK(event.position.z() == doctest::Approx(0.03).epsilon(0.01));
  CHECK(event.force > 0);
  CHECK(event.force < 0.1);
  push_to(bench, -5e-3);
  bench.wait(0.2);
  CHECK(std::abs(bench.resistance()) < 1e-3);
  push_to(bench, 1e-3);
  CHECK(bench.events(EventKind::hub).size() == 2);
  CHECK(bench.flags() == 0);
}

TEST_CASE("a tilted hub touches with its rim, and bears what an upright one does once it lies on all of its face") {
  for (const double tilt : {0.1, 0.2, 0.6, 1.0}) {
    CAPTURE(tilt);
    Bench bench(hub_scene(tilt));
    const double s = kHub / 2 * std::sin(tilt);  // m, of the rim below the middle
    push_to(bench, -s - 0.5e-3);
    double before = bench.needle().cutting_force.z(), steepest = 0;
    CHECK(std::abs(before) < 2e-3);
    bench.each_tick = [&] {
      const double now = bench.needle().cutting_force.z();
      CHECK(now > before - 5e-3);
      steepest = std::max(steepest, std::abs(now - before));
      before = now;
    };
    push_to(bench, 0, 0.02);
    const double at_middle = bench.needle().cutting_force.z();
    push_to(bench, 2e-3, 0.02);
    bench.each_tick = {};
    bench.wait(0.5);
    const double found = bench.needle().cutting_force.z();
    MESSAGE("tilt ", tilt, ": ", found, " N 2 mm deep, upright ", blunt_force(2e-3), " N; ", at_middle,
            " N at the middle");
    CHECK(at_middle > 0);
    if (2 * s < 2e-3) CHECK(found == doctest::Approx(blunt_force(2e-3)).epsilon(0.1).scale(0));
    if (2 * s > 2e-3) CHECK(found > 0.9 * blunt_force(2e-3));
    CHECK(steepest < 0.02);  // N per tick of 40 um
    CHECK(bench.events(EventKind::hub).size() == 1);
    bench.push(0, -0.01, 0.05);
    bench.wait(0.2);
    CHECK(std::abs(bench.needle().cutting_force.z()) < 2e-3);
    CHECK(bench.flags() == 0);
  }
}

TEST_CASE("the force on a hub follows as it is turned on the skin, there and back") {
  Bench bench(hub_scene());
  push_to(bench, 2e-3);
  bench.wait(0.5);
  const double upright = bench.resistance();
  bench.turn(0, {0, 0.15, 0}, 2);
  bench.turn(0, {0, -0.15, 0}, 2);
  CHECK(bench.resistance() == doctest::Approx(upright).epsilon(0.02).scale(0));
}

TEST_CASE("the skin holds a hub that is moved along it, up to its friction") {
  Scene scene = hub_scene();
  scene.tissue.regions[0].interaction.friction_contact = 0.5;
  scene.needles[0].rung = NeedleRung::flexible;
  Bench bench(scene);
  push_to(bench, 2e-3);
  bench.wait(0.5);
  const double normal = bench.resistance();
  bench.move(0, {1e-3, 0, 0}, 0.01);
  bench.wait(0.5);
  const Vector3 force = bench.needle().cutting_force;
  CHECK(force.x() < -0.05 * normal);
  CHECK(force.head<2>().norm() < 0.52 * force.z());  // the skin under the hub lies aslant
}

TEST_CASE("tissue that relaxes lets a hub that is pressed onto it and held feel the Prony series" *
          doctest::test_suite("gate")) {
  constexpr double kRatio = 0.8, kTime = 0.3;  // -, s
  const auto force_after = [&](bool relaxes, double time) {
    Scene scene = hub_scene();
    if (relaxes) scene.tissue.regions[0].material.relaxation = {{.ratio = kRatio, .time = kTime}};
    Bench bench(scene);
    push_to(bench, -0.2e-3);
    bench.wait(3);
    const double before = bench.resistance();
    push_to(bench, 0.5e-3, 0.1);
    bench.wait(time);
    return bench.resistance() - before;
  };
  const double rest = force_after(false, 2);
  for (const double time : {0.1, 0.3, 2.0}) {
    const double found = force_after(true, time) / rest, series = 1 + kRatio * std::exp(-time / kTime);
    MESSAGE("after ", time, " s: ", found, ", Prony series ", series);
    CHECK(found == doctest::Approx(series).epsilon(0.02).scale(0));
  }
}

TEST_CASE("a hub is stopped by windows' tissue, by a base on springs and by a flexible needle, too") {
  Scene scene = hub_scene();
  SUBCASE("window") { scene.tissue.window = 8; }
  SUBCASE("hold") { scene.needles[0].hold = BaseHold{}; }
  SUBCASE("flexible") { scene.needles[0].rung = NeedleRung::flexible; }
  Bench bench(scene);
  push_to(bench, 2e-3);
  bench.wait(1);
  const double blunt = blunt_force(0.03 - bench.needle().base.position.z());
  MESSAGE(bench.resistance(), " N, blunt tip ", blunt, " N");
  CHECK(bench.resistance() == doctest::Approx(blunt).epsilon(0.01).scale(0));
  CHECK(bench.flags() == 0);
}

}  // namespace acus::test
