// SPDX-License-Identifier: GPL-3.0-or-later
// A needle that comes out of a folded tissue and goes into it again: it feels the next surface like the first one.
#include <doctest/doctest.h>

#include <numbers>

#include "tests/support/temporary_folder.h"
#include "tests/tick/bench.h"
#include "tests/tick/notched_block.h"

namespace acus::test {
namespace {

constexpr double kSpeed = 0.03;                      // m/s
constexpr double kTop = 0.03, kThickness = 0.025;    // m, of the upper half; the slot is 10 mm high

class Notched {
 public:
  explicit Notched(double slot = 10e-3) : bench(scene(slot)) {}

  double steady_force(double depth) const {
    const Scene& scene = bench.simulation().scene();
    const Interaction& law = scene.tissue.regions[0].interaction;
    return law.cutting_force +
           std::numbers::pi * scene.needles[0].outer_diameter * law.friction_dynamic * *law.pressure * depth;
  }

 private:
  TemporaryFolder folder_;

  Scene scene(double slot) const {
    Scene scene = block_scene();
    scene.tissue.gmsh = GmshMesh{folder_.write("notched.msh", notched_block(slot)), 1};
    scene.needles = {needle_at({-0.0032, 0.0021, kTop}, 0.005)};
    scene.needles[0].length = 0.15;
    scene.needles[0].base.position.z() += 0.05;
    return scene;
  }

 public:
  Bench bench;
};

}  // namespace

TEST_CASE("a needle that is through punctures the next surface at f_p, and its path goes on there" *
          doctest::test_suite("gate")) {
  Notched notched;
  Bench& bench = notched.bench;
  bench.push(0, 0.005 + kThickness + 0.008, kSpeed);
  REQUIRE(bench.events(EventKind::exit).size() == 1);
  bench.wait(0.5);
  CHECK(bench.needle().phase == Phase::through);
  CHECK(bench.needle().tip_force.norm() == 0);
  CHECK(bench.needle().inserted_depth == doctest::Approx(kThickness).epsilon(0.1).scale(0));
  CHECK(bench.events(EventKind::contact).size() == 1);

  bench.push(0, 0.022, kSpeed);
  const auto punctures = bench.events(EventKind::puncture);
  REQUIRE(punctures.size() == 2);
  CHECK(punctures[1].force == doctest::Approx(0.4).epsilon(0.02).scale(0));
  CHECK(punctures[1].position.z() == doctest::Approx(-0.01).epsilon(0.6).scale(0));
  CHECK(bench.events(EventKind::contact).size() == 2);
  CHECK(bench.needle().phase == Phase::inside);
  // The air between the halves bears no friction, and does not count as depth.
  const double depth = bench.needle().inserted_depth;
  CHECK(depth == doctest::Approx(0.045).epsilon(0.15).scale(0));
  CHECK(bench.resistance() == doctest::Approx(notched.steady_force(depth)).epsilon(0.05).scale(0));
  CHECK(bench.needle().unheld == 0);
}

TEST_CASE("a needle that is drawn back out of the second half is through again, and punctures it anew" *
          doctest::test_suite("gate")) {
  Notched notched;
  Bench& bench = notched.bench;
  bench.push(0, 0.06, kSpeed);
  REQUIRE(bench.events(EventKind::puncture).size() == 2);
  bench.push(0, -0.025, kSpeed);
  REQUIRE(bench.events(EventKind::withdrawal).size() == 1);
  CHECK(bench.needle().phase == Phase::through);
  bench.push(0, 0.025, kSpeed);
  CHECK(bench.events(EventKind::puncture).size() == 3);
  CHECK(bench.needle().phase == Phase::inside);

  bench.push(0, -0.065, kSpeed);
  bench.wait(0.5);
  CHECK(bench.events(EventKind::withdrawal).size() == 3);
  CHECK(bench.needle().phase == Phase::free);
  CHECK(bench.needle().inserted_depth == 0);
  CHECK(bench.needle().base_force.norm() < 1e-3);
}

TEST_CASE("a needle goes through both halves, and back" * doctest::test_suite("gate")) {
  Notched notched;
  Bench& bench = notched.bench;
  bench.push(0, 0.075, kSpeed);
  CHECK(bench.events(EventKind::exit).size() == 2);
  CHECK(bench.needle().phase == Phase::through);
  CHECK(bench.needle().inserted_depth == doctest::Approx(2 * kThickness).epsilon(0.05).scale(0));
  bench.push(0, -0.08, kSpeed);
  CHECK(bench.needle().phase == Phase::free);
  CHECK(bench.events(EventKind::withdrawal).size() == 2);
}

TEST_CASE("a narrow gap is a gap: the second half is punctured, not entered unfelt" * doctest::test_suite("gate")) {
  for (const double slot : {1.5e-3, 3e-3}) {
    CAPTURE(slot);
    Notched notched(slot);
    Bench& bench = notched.bench;
    bench.push(0, 0.055, kSpeed);
    CHECK(bench.events(EventKind::exit).size() == 1);
    const auto punctures = bench.events(EventKind::puncture);
    REQUIRE(punctures.size() == 2);
    CHECK(punctures[1].force == doctest::Approx(0.4).epsilon(0.02).scale(0));
    CHECK(bench.needle().phase == Phase::inside);
  }
}

// Tissue does not touch itself: the tip presses the wall of the first half more than a millimetre into the second one.
TEST_CASE("a gap narrower than the wall gives way is told, and forces go on" * doctest::test_suite("gate")) {
  Notched notched(0.2e-3);
  Bench& bench = notched.bench;
  bench.may_intrude = true;
  bench.push(0, 0.055, kSpeed);
  CHECK(bench.events(EventKind::intrusion).size() == 1);
  CHECK((bench.flags() & kTipFoundInside) != 0);
  CHECK(bench.needle().phase == Phase::inside);
  CHECK(bench.resistance() == doctest::Approx(notched.steady_force(0.05)).epsilon(0.1).scale(0));
}

TEST_CASE("a needle that leaves both halves at once is out" * doctest::test_suite("gate")) {
  Notched notched;
  Bench& bench = notched.bench;
  bench.push(0, 0.06, kSpeed);
  REQUIRE(bench.needle().phase == Phase::inside);
  bench.may_intrude = true;
  bench.push(0, -0.08, 1000);
  bench.wait(1);
  CHECK(bench.needle().phase == Phase::free);
  CHECK(bench.needle().base_force.norm() < 1e-2);
}

TEST_CASE("a base that jumps takes a tip that is through into the second half, which is told") {
  Notched notched;
  Bench& bench = notched.bench;
  bench.push(0, 0.036, kSpeed);
  REQUIRE(bench.needle().phase == Phase::through);
  bench.may_intrude = true;
  bench.push(0, 0.02, 100);
  bench.wait(0.2);
  CHECK(bench.needle().phase == Phase::inside);
  CHECK((bench.events(EventKind::puncture).size() == 2 || bench.events(EventKind::intrusion).size() == 1));
  CHECK(bench.needle().inserted_depth == doctest::Approx(0.041).epsilon(0.15).scale(0));
}

}  // namespace acus::test
