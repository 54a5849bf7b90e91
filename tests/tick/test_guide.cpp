// SPDX-License-Identifier: GPL-3.0-or-later
// Guides, on a needle that touches no tissue: a cantilever of which a hole at the distance a from the base is moved
// aside by w. The hole bears F = 3 EI w/a³, and the tip beyond it goes straight on.
#include <doctest/doctest.h>

#include <numbers>

#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kArm = 0.06;  // m, a
constexpr int kGuide = 1;      // as Bench numbers bodies

Scene guided_scene(double play = 0, double friction = 0) {
  Scene scene = block_scene();
  scene.needles = {needle_at({0, 0, 0.03}, 0.05)};
  const Pose& base = scene.needles[0].base;
  Guide guide;
  guide.pose = {base * Vector3(kArm, 0, 0), base.orientation};
  guide.play = play;
  guide.friction = friction;
  scene.guides = {guide};
  return scene;
}

double bending_stiffness(const Needle& needle) {
  const double outer = needle.outer_diameter, inner = needle.inner_diameter;
  return needle.material.young_modulus * std::numbers::pi / 64 * (std::pow(outer, 4) - std::pow(inner, 4));
}

double cantilever_force(const Needle& needle, double aside) {
  return 3 * bending_stiffness(needle) * aside / (kArm * kArm * kArm);
}

double cantilever_tip(const Needle& needle, double aside) { return aside * (1 + 1.5 * (needle.length - kArm) / kArm); }

}  // namespace

TEST_CASE("a guide that is moved aside bends the needle, and its force is the base's") {
  const Scene scene = guided_scene();
  Bench bench(scene);
  const double tip = bench.needle().tip_position.x();
  constexpr double kAside = 4e-3;
  bench.move(kGuide, {kAside, 0, 0}, 0.02);
  bench.wait(0.5);
  const Vector3 force = bench.needle().guide_force;
  CHECK(force.x() == doctest::Approx(cantilever_force(scene.needles[0], kAside)).epsilon(0.01).scale(0));
  CHECK(std::abs(force.y()) < 1e-9);
  CHECK((force - bench.needle().base_force).norm() < 1e-9 * force.norm());
  CHECK(bench.needle().tip_position.x() - tip ==
        doctest::Approx(cantilever_tip(scene.needles[0], kAside)).epsilon(0.01).scale(0));
}

TEST_CASE("a hollow needle bends like a tube") {
  Scene scene = guided_scene();
  scene.needles[0].inner_diameter = 0.8e-3;
  Bench bench(scene);
  bench.move(kGuide, {0, 4e-3, 0}, 0.02);
  bench.wait(0.5);
  CHECK(bench.needle().guide_force.y() ==
        doctest::Approx(cantilever_force(scene.needles[0], 4e-3)).epsilon(0.01).scale(0));
}

TEST_CASE("play lets the needle move by the play and no more") {
  constexpr double kPlay = 1e-3;
  const Scene scene = guided_scene(kPlay);
  Bench bench(scene);
  const double tip = bench.needle().tip_position.x();
  bench.move(kGuide, {0.8 * kPlay, 0, 0}, 0.02);
  bench.wait(0.3);
  CHECK(bench.needle().guide_force.norm() < 1e-9);
  CHECK(std::abs(bench.needle().tip_position.x() - tip) < 1e-9);
  bench.move(kGuide, {2.2 * kPlay, 0, 0}, 0.02);  // 3 mm in all
  bench.wait(0.5);
  CHECK(bench.needle().guide_force.x() ==
        doctest::Approx(cantilever_force(scene.needles[0], 2 * kPlay)).epsilon(2e-3).scale(0));
  CHECK(bench.needle().tip_position.x() - tip ==
        doctest::Approx(cantilever_tip(scene.needles[0], 2 * kPlay)).epsilon(2e-3).scale(0));
}

TEST_CASE("a guide's friction is mu times its force across, against the sliding") {
  constexpr double kFriction = 0.3;
  Bench bench(guided_scene(0, kFriction));
  bench.move(kGuide, {4e-3, 0, 0}, 0.02);
  for (const double by : {0.01, -0.01}) {
    CAPTURE(by);
    bench.push(0, by, 0.02);
    const Vector3 force = bench.needle().guide_force, axis = bench.axis();
    const double along = force.dot(axis), across = (force - along * axis).norm();
    CHECK(across > 0.3);
    CHECK(along == doctest::Approx(-std::copysign(kFriction * across, by)).epsilon(6e-3).scale(0));
    CHECK((force - bench.needle().base_force).norm() < 3e-6 * force.norm());
  }
}

TEST_CASE("a needle that is drawn out of its guide is free, and goes in again" * doctest::test_suite("gate")) {
  Bench bench(guided_scene());
  bench.move(kGuide, {2e-3, 0, 0}, 0.02);
  bench.wait(0.3);
  const Vector3 held = bench.needle().guide_force;
  CHECK(held.norm() > 0.1);
  bench.push(0, -0.045, 0.05);  // 5 mm out of it
  bench.wait(1);
  CHECK(bench.needle().guide_force.norm() == 0);
  CHECK(bench.needle().base_force.norm() < 1e-9);
  CHECK(std::abs(bench.needle().tip_position.x()) < 1e-9);
  bench.move(kGuide, {-2e-3, 0, 0}, 0.02);
  bench.push(0, 0.045, 0.05);
  bench.wait(0.3);
  CHECK(bench.needle().guide_force.norm() < 1e-9);
  bench.move(kGuide, {2e-3, 0, 0}, 0.02);
  bench.wait(0.3);
  CHECK((bench.needle().guide_force - held).norm() < 1e-9 * held.norm());
  CHECK(bench.flags() == 0);
}

}  // namespace acus::test
