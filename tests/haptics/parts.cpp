// SPDX-License-Identifier: GPL-3.0-or-later
// Limits, ramp, registration, delay line, moving stiffness: what the loop is made of besides.
#include <doctest/doctest.h>

#include <numbers>

#include "client/haptics/delay_line.h"
#include "client/haptics/limits.h"
#include "client/haptics/moving_stiffness.h"
#include "client/haptics/ramp.h"
#include "client/haptics/registration.h"

using namespace acus::haptics;

TEST_CASE("a force grows no faster than its limit and falls as fast as it likes") {
  CHECK(norm(limited({{3, 4, 0}}, 2)) == doctest::Approx(2));
  CHECK(norm(limited({{0.3, 0.4, 0}}, 2)) == doctest::Approx(0.5));
  CHECK(limited_growth({{1, 0, 0}}, {{5, 0, 0}}, 0.5)[0] == doctest::Approx(1.5));
  CHECK(limited_growth({{5, 0, 0}}, {{0.1, 0, 0}}, 0.5)[0] == doctest::Approx(0.1));
}

TEST_CASE("a ramp takes its time, both ways") {
  Ramp ramp(0.05);
  for (int i = 0; i < 25; ++i) ramp.step(true, 1e-3);
  CHECK(ramp.factor() == doctest::Approx(0.5));
  for (int i = 0; i < 100; ++i) ramp.step(true, 1e-3);
  CHECK(ramp.factor() == 1);
  for (int i = 0; i < 10; ++i) ramp.step(false, 1e-3);
  CHECK(ramp.factor() == doctest::Approx(0.8));
  CHECK(Ramp(0).step(true, 1e-3) == 1);
}

TEST_CASE("a scaled and turned workspace keeps power") {
  const Workspace workspace{rotation({{0, std::numbers::pi / 2, 0}}), 2.0, 3.0};
  Registration registration(workspace);
  const Pose device{{{0.1, 0.2, 0.3}}, rotation({{0.1, 0, 0.2}})};
  const Pose base{{{1, 1, 1}}, rotation({{0.4, 0.5, 0.6}})};
  registration.bring_together(device, base);
  CHECK(norm(registration.base_of(device).position - base.position) < 1e-15);

  const Vector6 way{{1e-6, -2e-6, 3e-6, 2e-6, 1e-6, -1e-6}};
  const Vector6 needle_way = displacement(base, registration.base_of(displaced(device, way)));
  CHECK(needle_way[2] == doctest::Approx(-2e-6));  // the device's x is the world's -z, twice as far
  const Wrench at_base{{{1, -2, 0.5}}, {{0.3, 0.1, -0.2}}};
  const double power_at_device = dot(joined(registration.at_device(at_base)), way);
  CHECK(power_at_device == doctest::Approx(3.0 / 2.0 * dot(joined(at_base), needle_way)).epsilon(1e-5));
}

TEST_CASE("a delay line delivers late, in order, and the same for the same seed") {
  DelayLine<int, 8> line({0.01, 0.005, 5}), again({0.01, 0.005, 5});
  for (int i = 0; i < 8; ++i) line.send(1e-3 * i, i), again.send(1e-3 * i, i);
  CHECK_FALSE(line.receive(0.009).has_value());
  int next = 0;
  for (double now = 0; now < 0.1; now += 1e-4) {
    while (const auto item = line.receive(now)) {
      CHECK(*item == next++);
      CHECK(now > 1e-3 * *item + 0.01 - 1e-6);
      const auto other = again.receive(now);
      REQUIRE(other.has_value());
      CHECK(*other == *item);
    }
  }
  CHECK(next == 8);
}

TEST_CASE("inertia in free air is moving stiffness, a wall is not") {
  MovingStiffness moving;
  LocalModel model;
  moving.add(model, 900, 0);
  CHECK(moving.value() == doctest::Approx(900));
  CHECK(moving.slides(905));
  CHECK_FALSE(moving.slides(1500));
  model.backward_limit = Limit::contact;
  moving.add(model, 50000, 1e-3);
  CHECK(moving.value() == doctest::Approx(900));
  CHECK_FALSE(moving.slides(50000));
}

TEST_CASE("a viscous tissue's ticks are stiffer than what lasts") {
  MovingStiffness moving;
  LocalModel model;
  model.backward_limit = Limit::contact;
  for (int i = 0; i < 100; ++i) {  // a spring of 100 N/m whose ticks tell 1,100 N/m
    model.base.position[0] = 1e-5 * i;
    model.felt.force[0] = -100 * 1e-5 * i;
    moving.add(model, 1100, 0.5e-3);
  }
  CHECK(moving.value() == doctest::Approx(1000));
  model.backward_limit = Limit::none;
  for (int i = 0; i <= MovingStiffness::kTicks; ++i) {  // the tip leaves it
    CHECK(moving.value() == doctest::Approx(1000));
    moving.add(model, 300, 0);
  }
  CHECK(moving.value() == doctest::Approx(300));
}
