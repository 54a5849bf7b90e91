// SPDX-License-Identifier: GPL-3.0-or-later
// Two simulated hands on two handles, on one needle in a tissue with a closed form.
#include "client/haptics/shared_hand.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "client/haptics/analytic_tissue.h"
#include "client/haptics/kit.h"
#include "client/haptics/simulated_handle.h"

using namespace acus::haptics;

namespace {

// What the first hand's program tells the second one, and hears of it.
struct Told {
  Wrench felt;
  double stored = 0, share = 1;
  Vector6 way;
};

struct Pair {
  Pair(const AnalyticTissue::Properties& properties, const LinkDelay& network = {})
      : tissue(properties), there(network), back(network) {
    kit.begin({}, {});
  }

  Vector6 way_of(const SimulatedHandle& handle) const { return displacement({}, {handle.measured(), {}}); }

  // A sample; `meant` is where both hands mean to be (m), along x.
  void step(double share, double first_meant, double second_meant) {
    tissue.step(base);
    LocalModel model = tissue.model();
    model.seq = seq;
    kit.take(model);
    while (const auto way = back.receive(now)) second_way = *way;
    const Vector6 own = way_of(first);
    const Kit::Answer answer = kit.step({displaced({}, share * own + (1 - share) * second_way), false});
    base = answer.base.position[0], seq = answer.seq, felt = answer.on_hand;
    first_force = first_hand.step(1e-3, own - first_before, felt, answer.stored, share, second_way - own);
    first_before = own;
    there.send(now, {felt, answer.stored, share, own});
    while (const auto news = there.receive(now)) told = *news;
    const Vector6 other = way_of(second);
    second_force =
        second_hand.step(1e-3, other - second_before, told.felt, told.stored, 1 - told.share, told.way - other);
    second_before = other;
    back.send(now, other);
    first.write(first_force.force);
    second.write(second_force.force);
    first.mean({{first_meant, 0, 0}}, {});
    second.mean({{second_meant, 0, 0}}, {});
    first.advance(1e-3);
    second.advance(1e-3);
    now += 1e-3;
  }

  DeviceProperties device;
  AnalyticTissue tissue;
  Kit kit{device};
  SharedHand first_hand{device}, second_hand{device};
  SimulatedHandle first{{device.translation, {}, kGrips[1].hand}}, second{{device.translation, {}, kGrips[0].hand}};
  DelayLine<Told> there;
  DelayLine<Vector6> back;
  Told told;
  Vector6 second_way, first_before, second_before;
  Wrench felt, first_force, second_force;
  double now = 0, base = 0;
  std::uint64_t seq = 0;
};

}  // namespace

TEST_CASE("two hands move the needle by their shares, and bear its force by their shares") {
  for (const double share : {0.5, 0.2, 1.0}) {
    CAPTURE(share);
    Pair pair({300, 1e9, 0.5, 0.3, 0.005});
    for (int i = 0; i < 4000; ++i)
      pair.step(share, 0.02 * std::min(1.0, i / 1000.0), 0.015 * std::min(1.0, i / 1000.0));
    const double d1 = pair.first.position()[0], d2 = pair.second.position()[0];
    const double way = share * d1 + (1 - share) * d2;
    // The series of tissue and coupling, from the surface on.
    const double series = 1 / (1 / 300.0 + 1 / pair.kit.coupling().translation_spring);
    CHECK(-pair.felt.force[0] == doctest::Approx(series * (way - 0.005)).epsilon(0.02));
    const double between = pair.first_hand.stiffness() * (d2 - d1);
    CHECK(pair.first_force.force[0] == doctest::Approx(share * pair.felt.force[0] + between).epsilon(0.02));
    CHECK(pair.second_force.force[0] == doctest::Approx((1 - share) * pair.felt.force[0] - between).epsilon(0.02));
  }
}

TEST_CASE("a hand without a share is led by the other one") {
  Pair pair({300, 1e9, 0.5, 0.3, 1});  // in air
  for (int i = 0; i < 3000; ++i) pair.step(1, 0.03 * std::min(1.0, i / 1000.0), 0);
  const double lead = pair.first.position()[0], led = pair.second.position()[0];
  // The spring between them against the second hand's own, friction aside.
  CHECK(led == doctest::Approx(lead * 200 / (200 + kGrips[0].hand.stiffness)).epsilon(0.05));
  CHECK(pair.base == doctest::Approx(lead).epsilon(1e-3));
}

TEST_CASE("neither hand gets more than it has put in: stiff tissue, late and lost messages, a share that swings") {
  for (const LinkDelay& network : {LinkDelay{}, LinkDelay{.delay = 0.02, .jitter = 0.01, .loss = 0.05}})
    for (const double stiffness : {300.0, 1e5}) {
      CAPTURE(network.delay);
      CAPTURE(stiffness);
      Pair pair({stiffness, 1, 0.5, 0.3, 0.005}, network);
      double least = 1e9, most = -1e9;
      for (int i = 0; i < 8000; ++i) {
        const double t = 1e-3 * i, share = i < 6000 ? 0.5 + 0.5 * std::sin(6 * t) : 0.5;
        const double first = 0.02 * (1 - std::cos(2 * std::min(t, 6.0))),
                     second = 0.015 * (1 - std::cos(3 * std::min(t, 6.0)));
        pair.step(share, first, second);
        CHECK(pair.first_hand.passivity().account() > -1e-15);   // but for rounding
        CHECK(pair.second_hand.passivity().account() > -1e-15);  // but for rounding
        if (i < 7500) continue;
        least = std::min(least, pair.first_force.force[0]);
        most = std::max(most, pair.first_force.force[0]);
      }
      CHECK(pair.tissue.punctured());
      CHECK(pair.first.most_made() < 1e-9);
      CHECK(pair.second.most_made() < 1e-9);
      CHECK(most - least < 0.1);
    }
}

TEST_CASE("another hand comes and goes without a jump") {
  DeviceProperties device;
  SharedHand hand(device);
  double before = 0, largest = 0;
  Vector6 moved;
  moved[0] = -1e-3;
  hand.step(1e-3, moved, {}, 0, 1, std::nullopt);
  for (int i = 0; i < 600; ++i) {
    std::optional<Vector6> ahead;
    if (i >= 100 && i < 300) ahead.emplace()[0] = 5e-3;
    Vector6 pushed;  // by the other one, and held
    pushed[0] = -2e-6;
    const double force = hand.step(1e-3, pushed, {}, 0, 1, ahead).force[0];
    largest = std::max(largest, std::abs(force - before));
    before = force;
    if (i == 299) CHECK(force > 0.3);
  }
  CHECK(before == 0);
  CHECK(largest < 0.05);
}

TEST_CASE("options of a shared hand out of range are refused by their name") {
  CHECK_THROWS_WITH_AS(SharedHand({}, {.stiffness = -1}), "stiffness: expected >= 0, found -1.000000",
                       std::invalid_argument);
}
