// SPDX-License-Identifier: GPL-3.0-or-later
// Torsional friction: a needle that is spun in its path feels T = pi d l mu p d/2 at its base, and its tip lags.
#include <doctest/doctest.h>

#include <numbers>

#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kDepth = 0.05;             // m, inserted
constexpr double kTurn = std::numbers::pi;  // rad
constexpr double kRate = 2;                 // rad/s: slow

Scene spin_scene(double torsional_friction) {
  Scene scene = block_scene(0.08);
  scene.tissue.regions[0].material.young_modulus = 1e6;  // a skin that the needle hardly carries along
  scene.needles[0].torsional_friction = torsional_friction;
  return scene;
}

double expected_torque(const Bench& bench, double share) {
  const Needle& needle = bench.simulation().scene().needles[0];
  const Interaction& law = bench.simulation().scene().tissue.regions[0].interaction;
  const double d = needle.outer_diameter, l = bench.needle().inserted_depth;
  return share * std::numbers::pi * d * l * law.friction_dynamic * *law.pressure * d / 2;
}

// Of the tissue against the spin, about the needle's axis (N m).
double torque(const Bench& bench) { return bench.needle().base_torque.dot(bench.axis()); }

// Of the tip behind the base (rad): the torque is full outside and falls to zero along the shaft inside.
double expected_lag(const Bench& bench, double full_torque) {
  const Needle& needle = bench.simulation().scene().needles[0];
  const double d = needle.outer_diameter, inside = bench.needle().inserted_depth;
  const double shear = needle.material.young_modulus / (2 * (1 + needle.material.poisson_ratio));
  const double stiffness = shear * std::numbers::pi * d * d * d * d / 32;  // GJ
  return full_torque * (needle.length - inside / 2) / stiffness;
}

}  // namespace

TEST_CASE("a spun needle feels the friction of its shaft, and its tip lags; spun back, both turn round" *
          doctest::test_suite("gate")) {
  for (const double share : {1.0, 0.5}) {
    CAPTURE(share);
    Bench bench(spin_scene(share));
    bench.push(0, 0.005 + kDepth, 0.02);
    bench.wait(0.3);
    REQUIRE(bench.needle().inserted_depth == doctest::Approx(kDepth).epsilon(0.01).scale(0));
    bench.spin(0, kTurn, kRate);  // the skin that friction has carried along goes back
    const double full = expected_torque(bench, share);
    CHECK(torque(bench) == doctest::Approx(-full).epsilon(3e-5).scale(0));
    CHECK(bench.twist() == doctest::Approx(-expected_lag(bench, full)).epsilon(6e-4).scale(0));
    bench.spin(0, 0, kRate);
    CHECK(torque(bench) == doctest::Approx(full).epsilon(3e-5).scale(0));
    CHECK(bench.twist() == doctest::Approx(expected_lag(bench, full)).epsilon(6e-4).scale(0));
    CHECK((bench.flags() & kNotFinite) == 0);
  }
}

TEST_CASE("held still after a spin, torque is kept up to the static friction" * doctest::test_suite("gate")) {
  Bench bench(spin_scene(1));
  bench.push(0, 0.005 + kDepth, 0.02);
  bench.spin(0, kTurn, kRate);
  bench.wait(0.5);
  CHECK(torque(bench) < 0);
  const Interaction& law = bench.simulation().scene().tissue.regions[0].interaction;
  CHECK(torque(bench) > -expected_torque(bench, 1) * law.friction_static / law.friction_dynamic);
}

TEST_CASE("a straight push carries no torque, and takes away what a spin has left" * doctest::test_suite("gate")) {
  Bench bench(spin_scene(1));
  const double speed = 0.02;
  double most = 0;
  bench.each_tick = [&] { most = std::max(most, std::abs(torque(bench)) / std::max(1e-6, expected_torque(bench, 1))); };
  bench.push(0, 0.005 + kDepth / 2, speed);
  CHECK(most < 5e-5);  // 2e-5 measured
  bench.spin(0, 1, kRate);
  bench.wait(0.1);
  CHECK(std::abs(torque(bench)) > 0.9 * expected_torque(bench, 1));
  bench.push(0, kDepth / 4, speed);
  CHECK(std::abs(torque(bench)) < 1e-5 * expected_torque(bench, 1));
}

TEST_CASE("friction is one cone: a needle that spins fast feels less of it along itself" *
          doctest::test_suite("gate")) {
  const double speed = 0.02;
  double largest_error = 0;  // of the friction along the needle
  for (const double share : {1.0, 0.5}) {
    Bench bench(spin_scene(share));
    bench.push(0, 0.005 + kDepth / 2, speed);
    const double cut = bench.needle().cutting_force.norm();
    for (const double rate : {0.0, 10.0, 18.0, -18.0, 4.0}) {
      CAPTURE(rate);
      bench.screw(0, 0.004, speed, rate);
      const double d = bench.simulation().scene().needles[0].outer_diameter, full = expected_torque(bench, 1) / (d / 2);
      const double about = share * rate * d / 2, slip = std::hypot(speed, about);
      const double expected = full * speed / slip, error = std::abs(bench.resistance() - cut - expected) / expected;
      largest_error = std::max(largest_error, error);
      CHECK(error < 1e-5);  // 3e-6 measured
      CHECK(torque(bench) == doctest::Approx(-share * full * about / slip * d / 2).epsilon(2e-4).scale(1e-6));
    }
  }
  MESSAGE("friction along the needle, against the cone: within " << largest_error);
}

TEST_CASE("a held needle that spins gives up the force that friction held" * doctest::test_suite("gate")) {
  Bench bench(spin_scene(1));
  bench.push(0, 0.005 + kDepth, 0.02);
  const double cut = bench.needle().cutting_force.norm(), before = bench.resistance() - cut;
  bench.wait(0.1);
  CHECK(bench.resistance() - cut > 0.9 * before);
  bench.spin(0, 3 * kTurn, 5);
  CHECK(std::abs(bench.resistance() - cut) < 0.01 * before);
}

TEST_CASE("without torsional friction a needle spins freely" * doctest::test_suite("gate")) {
  Bench bench(spin_scene(0));
  bench.push(0, 0.005 + kDepth, 0.02);
  bench.wait(0.3);
  bench.spin(0, kTurn, kRate);
  CHECK(std::abs(torque(bench)) < 1e-5 * expected_torque(bench, 1));
  CHECK(std::abs(bench.twist()) < 3e-6 * expected_lag(bench, expected_torque(bench, 1)));
}

}  // namespace acus::test
