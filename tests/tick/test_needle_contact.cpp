// SPDX-License-Identifier: GPL-3.0-or-later
// Needles that touch each other: two cantilevers that cross at distances a and b from their bases. Where the base of
// one is moved towards the other by w beyond touch, F (a³/(3 EI_a) + b³/(3 EI_b)) = w.
#include <doctest/doctest.h>

#include <numbers>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"
#include "tests/support/needle_gap.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kArmA = 0.06, kArmB = 0.07;  // m, from the bases to where they cross
constexpr double kStart = 0.5e-3;             // m, between them at the start

double bending_stiffness(const Needle& needle) {
  return needle.material.young_modulus * std::numbers::pi / 64 * std::pow(needle.outer_diameter, 4);
}

// The first along x, the second along y above it.
Scene crossing_scene(double friction) {
  Scene scene;
  scene.rate = 1000;
  scene.tissue.rung = TissueRung::none;
  scene.needle_contact.friction = friction;
  Needle a;
  a.name = "a";
  a.length = 0.1;
  a.beams = 20;
  a.outer_diameter = 0.8e-3;
  Needle b = a;
  b.name = "b";
  b.outer_diameter = 1.2e-3;
  b.base.orientation = rotation_exp({0, 0, std::numbers::pi / 2});
  b.base.position = {kArmA, -kArmB, kStart + 1e-3};
  scene.needles = {a, b};
  return scene;
}

double gap(const Bench& bench, int i = 0, int j = 1) {
  const Model& model = bench.simulation().model();
  const State& state = bench.simulation().state();
  const auto at = [](int k) { return static_cast<std::size_t>(k); };
  return needle_gap(model.needles[at(i)], state.needles[at(i)], model.needles[at(j)], state.needles[at(j)]);
}

// Lowers the second needle by w beyond touch, and waits until both are at rest.
void press(Bench& bench, double w) {
  bench.move(1, {0, 0, -kStart - w}, 0.05);
  bench.wait(0.5);
}

}  // namespace

TEST_CASE("needles that cross bend each other as two cantilevers do") {
  for (const double w : {0.2e-3, 1e-3, 3e-3}) {
    CAPTURE(w);
    const Scene scene = crossing_scene(0);
    Bench bench(scene);
    press(bench, w);
    const double give = std::pow(kArmA, 3) / (3 * bending_stiffness(scene.needles[0])) +
                        std::pow(kArmB, 3) / (3 * bending_stiffness(scene.needles[1]));
    const Vector3 on_a = bench.needle(0).needle_force, on_b = bench.needle(1).needle_force;
    CHECK(-on_a.z() == doctest::Approx(w / give).epsilon(0.005).scale(0));  // 0.0003, 0.0005, 0.003
    CHECK((on_a + on_b).norm() < 1e-12);
    CHECK((bench.needle(0).base_force - on_a).norm() < 1e-6);
    CHECK((bench.needle(1).base_force - on_b).norm() < 1e-6);
    CHECK(bench.needle(0).base_torque.y() == doctest::Approx(-kArmA * on_a.z()).epsilon(0.01).scale(0));
    CHECK(std::abs(gap(bench)) < 0.3e-6);  // 0.13e-6: 1 um/N of flattening
    CHECK(bench.flags() == 0);
  }
}

TEST_CASE("no force comes before needles touch, and none is left when they are apart again") {
  Bench bench(crossing_scene(0.3));
  bench.move(1, {0, 0, -0.8 * kStart}, 0.05);
  bench.wait(0.1);
  CHECK(bench.needle(0).needle_force.norm() == 0);
  CHECK(bench.needle(0).base_force.norm() < 1e-12);
  bench.move(1, {0, 0, -2e-3}, 0.05);
  CHECK(bench.needle(0).needle_force.norm() > 0.05);
  bench.move(1, {0, 0, 2.1e-3}, 0.05);
  bench.wait(2);
  CHECK(bench.needle(0).needle_force.norm() == 0);
  CHECK(bench.needle(0).base_force.norm() < 1e-3);
}

TEST_CASE("a needle that slides over another bears mu times what presses them together") {
  const double mu = 0.3;
  Bench bench(crossing_scene(mu));
  press(bench, 1.5e-3);
  bench.move(1, {0, 8e-3, 0}, 0.02);  // along itself
  constexpr std::size_t kNode = 12;   // of both, near the crossing
  const auto tangent = [&](int needle) -> Vector3 {
    return bench.simulation().needle_orientations(needle)[kNode] * Vector3::UnitX();
  };
  const Vector3 n = tangent(0).cross(tangent(1)).normalized(), force = bench.needle(0).needle_force;
  const double across = force.dot(n);
  CHECK((force - across * n).norm() == doctest::Approx(mu * std::abs(across)).epsilon(0.005).scale(0));  // 0.0001
  CHECK(bench.needle(0).needle_force.y() > 0);
  const double held = bench.needle(0).needle_force.y();
  bench.wait(1);  // sticks
  CHECK(bench.needle(0).needle_force.y() == doctest::Approx(held).epsilon(0.001).scale(0));
  bench.move(1, {0, -8e-3, 0}, 0.02);
  CHECK(bench.needle(0).needle_force.y() < -0.25 * std::abs(bench.needle(0).needle_force.z()));
}

TEST_CASE("contacts slide along needles without steps in the force") {
  Bench bench(crossing_scene(0));
  press(bench, 1e-3);
  double before = bench.needle(0).needle_force.z(), most = 0;
  bench.each_tick = [&] {
    const double now = bench.needle(0).needle_force.z();
    most = std::max(most, std::abs(now - before));
    before = now;
    CHECK(gap(bench) > -0.6e-6);  // -0.23e-6
  };
  bench.move(1, {-0.03, 0.02, 0}, 0.05);  // over cells of both
  CHECK(bench.needle(0).needle_force.z() < -0.1);
  CHECK(most < 2e-3);  // 0.7e-3
}

TEST_CASE("without friction needles press each other across both, also where they cross at a small angle") {
  for (const double degrees : {4.0, 15.0, 60.0}) {
    CAPTURE(degrees);
    const double angle = degrees * std::numbers::pi / 180, arm = 0.06;
    Scene scene = crossing_scene(0);
    Pose& base = scene.needles[1].base;
    base.orientation = rotation_exp({0, 0, angle});
    base.position = {arm - arm * std::cos(angle), -arm * std::sin(angle), kStart + 1e-3};
    Bench bench(scene);
    press(bench, 0.6e-3);
    // Tangents where the two are nearest, on a grid.
    const auto point = [&](int needle, int i) {
      NeedleShape shape;
      put_shape(bench.simulation().state().needles[static_cast<std::size_t>(needle)], shape);
      return curve_point(bench.simulation().model().needles[static_cast<std::size_t>(needle)], shape, 0.5e-3 * i);
    };
    std::vector<CurvePoint> a, b;
    for (int i = 0; i < 200; ++i) a.push_back(point(0, i)), b.push_back(point(1, i));
    double least = 1;
    Vector3 along_a, along_b;
    for (const CurvePoint& p : a)
      for (const CurvePoint& q : b)
        if (const double d = (p.position - q.position).norm(); d < least)
          least = d, along_a = p.tangent, along_b = q.tangent;
    const Vector3 force = bench.needle(0).needle_force;
    CHECK(force.norm() > 0.02);
    CHECK(std::abs(force.dot(along_a)) < 1e-6 * force.norm());  // 3e-7
    CHECK(std::abs(force.dot(along_b)) < 1e-6 * force.norm());
    CHECK(gap(bench) > -0.1e-6);  // -0.03e-6
  }
}

TEST_CASE("needles side by side bear each other all along, and steadily") {
  Scene scene = crossing_scene(0.2);
  scene.needles[1].base = {{0.01, 0, kStart + 1e-3}, Quaternion::Identity()};
  Bench bench(scene);
  bench.move(1, {0, 0, -kStart - 2e-3}, 0.02);
  bench.wait(1);
  CHECK(gap(bench) > -0.05e-3);  // -0.024e-3, at 24 N near the bases
  const Vector3 force = bench.needle(0).needle_force;
  CHECK(force.z() < -0.1);
  double most = 0;
  bench.each_tick = [&] { most = std::max(most, (bench.needle(0).needle_force - force).norm()); };
  bench.wait(0.5);
  CHECK(most < 1e-8 * force.norm());  // 5e-11
}

TEST_CASE("a tip that meets another shaft bends it ahead") {
  Scene scene = crossing_scene(0.5);
  scene.needles[1].base = {{0.05, -0.11, 0}, rotation_exp({0, 0, std::numbers::pi / 2})};
  Bench bench(scene);
  bench.each_tick = [&] { CHECK(gap(bench) > -0.7e-6); };  // -0.23e-6
  bench.push(1, 0.012, 0.02);
  bench.wait(0.5);
  constexpr double kArm = 0.05;
  const double ahead = 0.002 + scene.needles[0].outer_diameter / 2;
  const double force = 3 * bending_stiffness(scene.needles[0]) * ahead / std::pow(kArm, 3);
  CHECK(bench.needle(1).needle_force.y() == doctest::Approx(-force).epsilon(0.02).scale(0));
  CHECK(bench.needle(1).tip_position.y() == doctest::Approx(0.002).epsilon(0.01));
}

TEST_CASE("rigid needles that are driven into each other push as hard as tubes flatten") {
  Scene scene = crossing_scene(0);
  for (Needle& needle : scene.needles) needle.rung = NeedleRung::rigid;
  Bench bench(scene);
  press(bench, 10e-6);
  CHECK(bench.needle(1).needle_force.z() == doctest::Approx(10).epsilon(0.01).scale(0));
}

TEST_CASE("a rigid needle on springs rests on another one") {
  Scene scene = crossing_scene(0);
  for (Needle& needle : scene.needles) needle.rung = NeedleRung::rigid;
  scene.needles[1].hold = BaseHold{.stiffness = 500, .damping = 5, .angular_stiffness = 1e3, .angular_damping = 1};
  Bench bench(scene);
  press(bench, 2e-3);
  CHECK(bench.needle(1).needle_force.z() == doctest::Approx(500 * 2e-3).epsilon(0.01));
}

TEST_CASE("needles that may pass through each other do, and bear nothing") {
  Scene scene = crossing_scene(0.2);
  scene.needle_contact.enabled = false;
  Bench through(scene);
  double least = 1;
  through.each_tick = [&] {
    least = std::min(least, gap(through));
    CHECK(through.needle(0).base_force.norm() < 1e-12);
    CHECK(through.needle(0).needle_force.norm() == 0);
  };
  through.move(1, {0, 0, -5e-3}, 0.05);
  CHECK(least < -0.9e-3);
  CHECK(gap(through) > 1e-3);
}

TEST_CASE("a scene whose needles overlap is refused, unless they may") {
  Scene scene = crossing_scene(0.2);
  scene.needles[1].base.position.z() = 0.8e-3;
  CHECK_THROWS_WITH_AS(Simulation{scene},
                       doctest::Contains("needles[1].base: expected needle \"b\" beside needle \"a\", found it 0.2 mm "
                                         "inside it at 70 mm from its base"),
                       SceneError);
  scene.needle_contact.enabled = false;
  CHECK_NOTHROW(Simulation{scene});
}

TEST_CASE("needles that are waved about never pass through each other" * doctest::test_suite("gate")) {
  double worst = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    Scene scene = crossing_scene(random.uniform(0, 0.6));
    Needle third = scene.needles[0];
    third.name = "c";
    third.base = {{0.02, 0.03, 0.02}, rotation_exp({0, 0.3, -0.5})};
    scene.needles.push_back(third);
    if (seed % 3 == 0) scene.needles[2].rung = NeedleRung::rigid;
    Bench bench(scene);
    bench.each_tick = [&] {
      Vector3 sum = Vector3::Zero();
      for (int i = 0; i < 3; ++i) sum += bench.needle(i).needle_force;
      CHECK(sum.norm() < 1e-9);
      for (int j = 1; j < 3; ++j)
        for (int i = 0; i < j; ++i) worst = std::min(worst, gap(bench, i, j));
    };
    for (int leg = 0; leg < 5; ++leg)
      bench.move(random.index(3), random.uniform(2e-3, 12e-3) * random.direction(), random.uniform(0.02, 0.3));
    CHECK(bench.finite());
  }
  MESSAGE("they overlap by at most ", -1e6 * worst, " um");
  CHECK(worst > -0.02e-3);
}

}  // namespace acus::test
