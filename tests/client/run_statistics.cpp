// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/run_statistics.h"

#include <doctest/doctest.h>

#include "client/client.h"

using acus::client::RunStatistics;
using acus::client::Vanished;
using acus::protocol::Force;

namespace {

Force force_at(std::uint64_t tick, std::uint64_t seq = 0, const char* needle = "needle") {
  Force force;
  force.epoch = 1;
  force.tick = tick;
  force.seq = seq;
  force.needle = needle;
  return force;
}

}  // namespace

TEST_CASE("gaps in the ticks of each needle count as lost states, those before the first do not") {
  RunStatistics statistics;
  for (const std::uint64_t tick : {40, 41, 44, 45}) statistics.take(force_at(tick, 0, "a"), 0);
  for (const std::uint64_t tick : {40, 42}) statistics.take(force_at(tick, 0, "b"), 0);
  CHECK(statistics.states() == 6);
  CHECK(statistics.needles().at("a").lost == 2);
  CHECK(statistics.needles().at("b").lost == 1);
  CHECK(statistics.lost() == 3);
}

TEST_CASE("the rate is ticks per second between the first and the last state") {
  RunStatistics statistics;
  CHECK(statistics.rate() == 0);
  statistics.take(force_at(10), 5.0);
  statistics.take(force_at(510), 6.0);
  CHECK(statistics.rate() == doctest::Approx(500));
}

TEST_CASE("another epoch or a tick that comes again end the run") {
  RunStatistics statistics;
  statistics.take(force_at(10), 0);
  CHECK_THROWS_AS(statistics.take(force_at(10), 0), Vanished);
  CHECK_THROWS_AS(statistics.take(force_at(1), 0), Vanished);
  auto other = force_at(11);
  other.epoch = 2;
  CHECK_THROWS_AS(statistics.take(other, 0), Vanished);
}

TEST_CASE("latency counts the first state that used each of our poses") {
  RunStatistics statistics;
  statistics.take(force_at(1, 7), 0.0);   // somebody else's command
  statistics.take(force_at(2, 8), 0.11);  // our first
  statistics.take(force_at(3, 8), 0.20);
  statistics.take(force_at(4, 10), 0.33);  // 9 was overtaken
  const auto latency = statistics.latency({0.10, 0.20, 0.30}, 8);
  CHECK(latency.count == 2);
  CHECK(latency.p50 == doctest::Approx(0.01));
  CHECK(latency.max == doctest::Approx(0.03));
}

TEST_CASE("extremes keep push, pull, lateral force and torque apart") {
  RunStatistics statistics;
  auto force = force_at(1);
  force.base_force_in_base = {-2, 3, 4};
  force.base_torque = {0, 0, -0.5};
  force.depth = 0.03;
  statistics.take(force, 0);
  force = force_at(2);
  force.base_force_in_base = {1.5, 0, 0};
  statistics.take(force, 0);
  const auto& extremes = statistics.needles().at("needle").extremes;
  CHECK(extremes.push == 2);
  CHECK(extremes.pull == 1.5);
  CHECK(extremes.lateral == doctest::Approx(5));
  CHECK(extremes.torque == doctest::Approx(0.5));
  CHECK(extremes.depth == 0.03);
}

TEST_CASE("overruns and rejections count from the first statistics on") {
  RunStatistics statistics;
  CHECK(statistics.overruns() == 0);
  acus::protocol::Stats stats;
  stats.overruns = 12;
  stats.rejected = 3;
  statistics.take(stats);
  CHECK(statistics.overruns() == 0);
  stats.overruns = 15;
  statistics.take(stats);
  CHECK(statistics.overruns() == 3);
  CHECK(statistics.rejections() == 0);
}
