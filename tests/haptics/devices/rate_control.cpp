// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/haptics/devices/rate_control.h"

#include <doctest/doctest.h>

using namespace acus::haptics;

TEST_CASE("a full deflection moves at full speed, one in the dead zone not at all") {
  RateControl control({0.03, 0.5, 0.1});
  control.step({}, 0);
  Pose pose;
  for (int i = 1; i <= 100; ++i) pose = control.step({{{1, 0.09, -2}}, {}}, 0.01 * i);
  CHECK(pose.position[0] == doctest::Approx(0.03));
  CHECK(pose.position[1] == 0);
  CHECK(pose.position[2] == doctest::Approx(-0.03));
  for (int i = 101; i <= 200; ++i) pose = control.step({{}, {{0, 0, 1}}}, 0.01 * i);
  CHECK(rotation_vector(pose.orientation)[2] == doctest::Approx(0.5));
}

TEST_CASE("a long silence does not make the pose jump") {
  RateControl control;
  control.step({{{1, 0, 0}}, {}}, 0);
  CHECK(control.step({{{1, 0, 0}}, {}}, 1000).position[0] < 0.01);
}
