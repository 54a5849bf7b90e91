// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of acus-haptic that need no server: what is asked of a reading, the check at rest, a link that loses.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "client/haptics/delay_line.h"
#include "client/haptics/program/checked_reading.h"
#include "client/haptics/program/plain_rendering.h"
#include "client/haptics/program/rest_check.h"

using namespace acus::haptics;

TEST_CASE("a reading is a place that a hand can reach, and a rotation") {
  Device::Reading reading;
  CHECK_NOTHROW(checked(reading));
  for (const double place : {1e308, -2.1, std::numeric_limits<double>::infinity(), std::nan("")}) {
    reading = {};
    reading.pose.position[1] = place;
    CHECK_THROWS_WITH_AS(checked(reading), doctest::Contains("y = "), DeviceError);
  }
  reading = {};
  reading.pose.orientation = {0, 0, 0, 0};
  CHECK_THROWS_WITH_AS(checked(reading), doctest::Contains("length 0"), DeviceError);
  reading.pose.orientation.w = std::nan("");
  CHECK_THROWS_AS(checked(reading), DeviceError);
}

// Rests for a second from `begin`; felt and the server's force in N.
void rest(RestCheck& check, double begin, double felt, double server) {
  for (int i = 0; i < 1000; ++i) check.add(begin + 1e-3 * i, Vector3{{0.1, 0, 0}}, felt, server);
}

TEST_CASE("the check at rest tells the largest difference, and of a moving hand nothing") {
  RestCheck check;
  for (int i = 0; i < 1000; ++i) check.add(1e-3 * i, Vector3{{1e-5 * i, 0, 0}}, 0.2, 1.0);  // 10 mm/s
  CHECK_FALSE(check.worst());
  rest(check, 1, 0.01, 0.05);  // too little to compare
  CHECK_FALSE(check.worst());
  rest(check, 2, 1.01, 1.0);
  REQUIRE(check.worst());
  CHECK_FALSE(check.differs());
  rest(check, 3, 0.5, 1.0);
  rest(check, 4, 1.0, 1.0);
  CHECK(check.differs());
  CHECK(check.worst()->felt == doctest::Approx(0.5));
}

TEST_CASE("a link loses its share, delivers the rest in order, and does the same again") {
  const auto received = [](double loss) {
    DelayLine<int> link({.delay = 0.01, .jitter = 0.005, .seed = 3, .loss = loss});
    std::vector<int> all;
    for (int i = 0; i < 1000; ++i) {
      link.send(1e-3 * i, i);
      while (const auto item = link.receive(1e-3 * i)) all.push_back(*item);
    }
    return all;
  };
  CHECK(received(0).size() > 980);
  const std::vector<int> some = received(0.2);
  CHECK(some.size() == doctest::Approx(790).epsilon(0.05));
  CHECK(std::is_sorted(some.begin(), some.end()));
  CHECK(some == received(0.2));
}

TEST_CASE("without the kit the pose goes through as it is, and the force up to what the device can") {
  DeviceProperties properties;
  properties.translation.largest_force = 3;
  PlainRendering plain(properties, {});
  plain.begin({}, {{{0, 0, 0.2}}, {}});
  plain.take({{{-4, 0, 0}}, {}});
  const Kit::Answer answer = plain.step({{{0.01, 0, 0}}, {}});
  CHECK(answer.base.position[0] == doctest::Approx(0.01));
  CHECK(answer.base.position[2] == doctest::Approx(0.2));
  CHECK(answer.on_hand.force[0] == doctest::Approx(-3));
  CHECK(answer.seq == 1);
}
