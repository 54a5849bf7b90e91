// SPDX-License-Identifier: GPL-3.0-or-later
// Friction along the shaft over the speed of sliding, in and back.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/engine/math/random.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

struct Measured {
  double speed = 0, friction = 0;  // m/s, N/m
};

// Of the shaft in a phantom of PVC of 25.3 kPa [DiMaio, Salcudean 2003, doi 10.1109/TRA.2003.817044].
constexpr Measured kPhantom[] = {{1e-3, 34}, {3e-3, 59}, {9e-3, 80}};

// T = 3.7 N/m, b = 44.6 kN s/m², v_t = 2.11 mm/s, n = 0 go through all three. No T + c vⁿ with T >= 0 comes nearer than
// 6.5 %: the last step of the three is smaller than that of a logarithm.
Scene phantom() {
  Scene scene = block_scene(0.06);
  Region& region = scene.tissue.regions[0];
  region.material.young_modulus = 25.3e3;
  Interaction& law = region.interaction;
  law.friction_static = law.friction_dynamic =
      3.7 / (std::numbers::pi * scene.needles[0].outer_diameter * *law.pressure);
  law.friction_viscous = 44.6e3;
  law.friction_thinning_speed = 2.11e-3;
  return scene;
}

double friction_at(const Interaction& law, double d, double speed) {
  return std::numbers::pi * d * law.friction_dynamic * *law.pressure +
         law.friction_viscous * speed * std::pow(1 + speed / *law.friction_thinning_speed, law.friction_exponent - 1);
}

// Of the shaft, per metre of it in the tissue, with its sign: positive against the way in.
double friction_per_metre(const Bench& bench) {
  const NeedleReport& needle = bench.needle();
  return -needle.friction_force.dot(bench.axis()) / needle.inserted_depth;
}

}  // namespace

TEST_CASE("a phantom's friction at three speeds is the measured one" * doctest::test_suite("gate")) {
  Bench bench(phantom());
  bench.push(0, 0.02, 0.02);
  for (const Measured& measured : kPhantom) {
    bench.push(0, 0.01, measured.speed);  // until the tissue that is carried along moves no more
    const double found = friction_per_metre(bench);
    CAPTURE(measured.speed);
    MESSAGE("at ", 1e3 * measured.speed, " mm/s: ", found, " N/m, measured ", measured.friction);
    CHECK(found == doctest::Approx(measured.friction).epsilon(0.05).scale(0));
  }
}

TEST_CASE("a steady slip has the friction of its speed, in and back, and in one cone with torsion" *
          doctest::test_suite("gate")) {
  for (const double share : {0.0, 1.0}) {
    Scene scene = phantom();
    scene.tissue.regions[0].material.young_modulus = 1e6;  // hardly carried along
    Interaction& law = scene.tissue.regions[0].interaction;
    law.friction_exponent = 0.3;
    law.friction_viscous = 20e3;
    law.friction_back = 0.4;
    scene.needles[0].torsional_friction = share;
    Bench bench(scene);
    CAPTURE(share);
    const double d = scene.needles[0].outer_diameter;
    bench.push(0, 0.03, 0.05);
    for (const double speed : {0.05, 0.01, 0.003}) {
      bench.push(0, 0.004, speed);
      CHECK(friction_per_metre(bench) == doctest::Approx(friction_at(law, d, speed)).epsilon(2e-3).scale(0));
    }
    for (const double speed : {0.02, 0.005}) {
      bench.push(0, -0.004, speed);
      CHECK(friction_per_metre(bench) == doctest::Approx(-0.4 * friction_at(law, d, speed)).epsilon(2e-3).scale(0));
    }
    CHECK((bench.flags() & (kLawsNotConverged | kSolverFellBack)) == 0);
  }
}

TEST_CASE("friction that thins meets its laws in every tick of random motions, and stays within its bounds" *
          doctest::test_suite("gate")) {
  Random random(1);
  for (int run = 0; run < 6; ++run) {
    Scene scene = phantom();
    Interaction& law = scene.tissue.regions[0].interaction;
    law.friction_thinning_speed = std::exp(random.uniform(std::log(1e-6), std::log(1e-1)));
    law.friction_exponent = random.uniform(0, 0.9);
    law.friction_back = random.uniform(0.2, 1.5);
    law.friction_viscous *= 100 / friction_at(law, scene.needles[0].outer_diameter, 0.05);
    scene.needles[0].torsional_friction = run % 2;
    Bench bench(scene);
    CAPTURE(run);
    double fastest = 0;
    const double most = friction_at(law, scene.needles[0].outer_diameter, 0.05);
    bench.each_tick = [&] {
      CHECK(bench.simulation().report().residual <= scene.laws.tolerance);
      if (bench.needle().inserted_depth < 5e-3) return;
      const double friction = friction_per_metre(bench);
      fastest = std::max(fastest, friction);
      CHECK(friction < 1.1 * most);
      CHECK(friction > -1.1 * law.friction_back * most);
    };
    bench.push(0, 0.03, 0.05);
    for (int k = 0; k < 8; ++k) {
      const double speed = random.uniform(1e-3, 0.05), by = random.uniform(-0.004, 0.006);
      if (run % 2) bench.screw(0, by, speed, random.uniform(-18, 18));
      bench.push(0, by, speed);
      bench.wait(random.uniform(0, 0.1));
    }
    CHECK(fastest > 0.8 * most);
  }
}

}  // namespace acus::test
