// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/replay/run_statistics.h"

#include <doctest/doctest.h>

#include <cmath>

#include "client/link/client.h"

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

TEST_CASE("round trips end with the first state that used each of our poses") {
  RunStatistics statistics;
  statistics.take(force_at(1, 7), 0.0);   // somebody else's command
  statistics.take(force_at(2, 8), 0.11);  // our first
  statistics.take(force_at(3, 8), 0.20);
  statistics.take(force_at(4, 10), 0.33);  // 9 was overtaken
  const auto trips = statistics.round_trips({0.10, 0.20, 0.30}, 8);
  REQUIRE(trips.size() == 2);
  CHECK(trips[0].seq == 8);
  CHECK(trips[0].sent == 0.10);
  CHECK(trips[0].seconds == doctest::Approx(0.01));
  CHECK(trips[1].seq == 10);
  CHECK(trips[1].seconds == doctest::Approx(0.03));
}

TEST_CASE("the beat of the ticks is told in spite of skipped ticks and states that are held up") {
  RunStatistics statistics;
  constexpr double kPeriod = 1e-3;
  double due = 7.0004;
  for (std::uint64_t tick = 1; tick <= 200; ++tick) {
    const double held_up = tick % 7 == 0 ? 0.4e-3 : tick % 5 == 0 ? 30e-6 : 0;
    statistics.take(force_at(tick, 0, "a"), due + held_up);
    statistics.take(force_at(tick, 0, "b"), due + held_up + 50e-6);
    due += tick % 20 == 0 ? 3 * kPeriod : kPeriod;
  }
  CHECK(std::remainder(statistics.typical_arrival(kPeriod) - 7.0004, kPeriod) == doctest::Approx(0).epsilon(1e-6));
}

TEST_CASE("the beat of the ticks is told even if the first state was held up by half a period") {
  RunStatistics statistics;
  constexpr double kPeriod = 1e-3;
  for (std::uint64_t tick = 1; tick <= 200; ++tick) {
    const double held_up = tick == 1 ? 0.5 * kPeriod : static_cast<double>(tick % 5) * 20e-6;
    statistics.take(force_at(tick), 7 + static_cast<double>(tick) * kPeriod + held_up);
  }
  CHECK(std::remainder(statistics.typical_arrival(kPeriod) - 7, kPeriod) == doctest::Approx(40e-6).epsilon(1e-6));
}

TEST_CASE("flags are counted one by one, and so are the solvers") {
  RunStatistics statistics;
  auto force = force_at(1);
  force.flags = acus::protocol::kPathFull | acus::protocol::kPublishingReduced;
  statistics.take(force, 0);
  force.tick = 2;
  force.flags = acus::protocol::kPathFull;
  force.solver = acus::protocol::LawSolver::direct;
  statistics.take(force, 0);
  CHECK(statistics.solved()[0] == 1);
  CHECK(statistics.solved()[1] == 1);
  for (std::size_t bit = 0; bit < statistics.flagged().size(); ++bit) {
    CHECK(statistics.flagged()[bit] == (bit == 4 ? 2 : bit == 9 ? 1 : 0));
  }
}

TEST_CASE("late ticks are summed up after the first statistics, which speak of the time before the run") {
  RunStatistics statistics;
  acus::protocol::Stats stats;
  for (const std::uint64_t late : {50, 2, 3}) {
    stats.ticks = 100;
    stats.late = late;
    stats.wake_max = static_cast<double>(late) * 1e-3;
    statistics.take(stats);
  }
  CHECK(statistics.punctuality().ticks == 200);
  CHECK(statistics.punctuality().late == 5);
  CHECK(statistics.punctuality().wake_max == 3e-3);
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
