// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/haptics/passivity.h"

#include <doctest/doctest.h>

#include <cmath>

#include "client/haptics/delay_line.h"

using namespace acus::haptics;

namespace {

const Coupling kCouplings{1000, 0.5};  // N/m, N m/rad

Vector6 along_x(double way) { return {{way, 0, 0, 0, 0, 0}}; }
Wrench pull(double force) { return {{{force, 0, 0}}, {}}; }

}  // namespace

TEST_CASE("a spring up to the bound is rendered as it is, in and out again") {
  for (const double k : {10.0, 500.0, 1000.0}) {
    Passivity passivity(kCouplings, 0);
    double x = 0;
    for (int i = 0; i < 400; ++i) {
      const double way = i < 200 ? 5e-5 : -5e-5;
      x += way;
      passivity.observe(along_x(way));
      const double stored = k * x * x / 2;
      CHECK(passivity.control(pull(-k * x), stored).force[0] == doctest::Approx(-k * x).epsilon(1e-9).scale(1e-6));
    }
    CHECK(passivity.withheld() == doctest::Approx(0).scale(1e-9));
  }
}

TEST_CASE("a spring stiffer than the bound is rendered with the bound's stiffness, both ways") {
  Passivity passivity(kCouplings, 0);
  double x = 0;
  for (int i = 0; i < 200; ++i) {
    const double way = i < 100 ? 5e-5 : -5e-5;
    x += way;
    passivity.observe(along_x(way));
    const double force = passivity.control(pull(-1e6 * x), 1e6 * x * x / 2).force[0];
    CHECK(force == doctest::Approx(-1000 * x).epsilon(1e-6).scale(1e-3));
  }
}

TEST_CASE("of a late sample the device's damping has eaten less") {
  Passivity prompt(kCouplings, 0), late(kCouplings, 0);
  prompt.observe(along_x(1e-3));
  late.observe(along_x(1e-3), 10);
  CHECK(prompt.account() == doctest::Approx(1000 * 1e-6 / 2));
  CHECK(late.account() == doctest::Approx(prompt.account() / 10));
}

TEST_CASE("an account below zero renders nothing, and nothing is a number") {
  Passivity passivity(kCouplings, 0);
  passivity.observe(along_x(1e-3));
  CHECK(passivity.control(pull(0.5), 1).force[0] > 0.4);
  passivity.observe(along_x(2e-3), 100);  // goes with the force, and late
  CHECK(passivity.account() < 0);
  CHECK(passivity.control(pull(0), 0).force[0] == 0);
  passivity.observe(along_x(0));
  CHECK(passivity.control(pull(0.5), 1).force[0] == 0);
  CHECK(std::isfinite(passivity.given()));
}

TEST_CASE("whatever is asked for, the account never falls below zero and no energy is made") {
  std::uint64_t random = 7;
  Passivity passivity(kCouplings, 0);
  double given = 0, eaten = 0;  // J: by the force, by a damper that the bound lets the device have
  Wrench force;
  for (int i = 0; i < 100000; ++i) {
    Vector6 way;
    for (int axis = 0; axis < 6; ++axis) way[axis] = (next_random(random) - 0.5) * (axis < 3 ? 2e-3 : 2e-2);
    given += dot(joined(force), way);
    for (int axis = 0; axis < 6; ++axis) eaten += (axis < 3 ? 1000 : 0.5) / 2 * way[axis] * way[axis];
    passivity.observe(way);
    CHECK(passivity.account() > -1e-12);
    Wrench wanted;
    for (int axis = 0; axis < 3; ++axis) {
      wanted.force[axis] = (next_random(random) - 0.5) * 20;
      wanted.torque[axis] = (next_random(random) - 0.5) * 0.2;
    }
    force = passivity.control(wanted, 1);
  }
  CHECK(given < eaten);
}

TEST_CASE("a force that turns late, as a delay makes it, is not paid for by what friction ate before") {
  Passivity passivity(kCouplings, 0);
  for (int i = 0; i < 1000; ++i) {  // a hand drags against 1 N, which stores half a millijoule in a spring of 1,000 N/m
    passivity.observe(along_x(1e-4));
    passivity.control(pull(-1), 0.5e-3);
  }
  double given = 0, force = -1;
  for (int i = 0; i < 1000; ++i) {  // and goes back, while the force stays
    given += force * -1e-4;
    passivity.observe(along_x(-1e-4));
    force = passivity.control(pull(-1), 0.5e-3).force[0];
  }
  // What was stored, the reserve of it, and what the damper eats: 1,000/2 N/m of 0.1 mm a sample.
  CHECK(given < 0.5e-3 * 1.1 + 2e-6 + 1000 * 500 * 1e-8);
  CHECK(passivity.withheld() > 0.08);
}

TEST_CASE("forces on their way to a late device bound what can be made") {
  constexpr int kDelay = 5;
  const Coupling late{1000.0 / (1 + 2 * kDelay), 0};
  Passivity passivity(late, kDelay);
  std::array<double, kDelay + 1> pipe{};
  std::uint64_t random = 3;
  double given = 0, eaten = 0, x = 0;
  for (int i = 0; i < 100000; ++i) {
    const double way = (next_random(random) - 0.5) * 1e-3;
    const double acting = pipe[0];
    given += acting * way;
    eaten += (0.5 + kDelay) * late.translation * way * way;
    x += way;
    passivity.observe(along_x(way));
    for (int k = 0; k < kDelay; ++k) pipe[static_cast<std::size_t>(k)] = pipe[static_cast<std::size_t>(k + 1)];
    pipe[kDelay] = passivity.control(pull(-1e5 * x), 1).force[0];
  }
  CHECK(given < eaten);
}
