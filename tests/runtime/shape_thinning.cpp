// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/shape_thinning.h"

#include <doctest/doctest.h>

#include "server/engine/math/random.h"

namespace acus {
namespace {

constexpr TopicSet kNeedle = bit(Topic::needle), kTissue = bit(Topic::tissue);

// A tick with these shapes due; what went out.
TopicSet tick(ShapeThinning& thinning, TopicSet due, bool overran) {
  const TopicSet packed = thinning.begin(due);
  thinning.end(overran);
  return packed;
}

}  // namespace

TEST_CASE("punctual ticks, and late ones without shapes, leave none out") {
  ShapeThinning thinning(4);
  for (int i = 0; i < 100; ++i) {
    const TopicSet due = i % 3 == 0 ? kNeedle | kTissue : 0;
    CHECK(tick(thinning, due, due == 0) == due);
    CHECK_FALSE(thinning.left_out());
  }
}

TEST_CASE("a tick that took too long costs the next shapes of its larger topic, then one is tried again") {
  ShapeThinning thinning(4);
  CHECK(tick(thinning, kNeedle | kTissue, true) == (kNeedle | kTissue));
  for (int i = 0; i < 3; ++i) {
    CHECK(tick(thinning, kNeedle, false) == kNeedle);
    CHECK_FALSE(thinning.left_out());
    CHECK(tick(thinning, kNeedle | kTissue, false) == kNeedle);
    CHECK(thinning.left_out());
  }
  CHECK(tick(thinning, kTissue, true) == kTissue);
  CHECK(tick(thinning, kTissue, false) == 0);
  CHECK(tick(thinning, kNeedle, true) == kNeedle);
  CHECK(tick(thinning, kNeedle, false) == 0);
}

TEST_CASE("with one of one nothing is left out") {
  ShapeThinning thinning(1);
  for (int i = 0; i < 10; ++i) CHECK(tick(thinning, kNeedle, true) == kNeedle);
}

// Late ticks at random and in bursts, as on a host that others share.
TEST_CASE("shapes are left out in at most three times as many ticks as took too long") {
  Random random(1);
  for (int run = 0; run < 100; ++run) {
    ShapeThinning thinning(4);
    const double often = random.uniform(0, 0.1);
    int late = 0, left_out = 0, burst = 0;
    for (int i = 0; i < 9000; ++i) {
      if (burst > 0)
        --burst;
      else if (random.uniform(0, 1) < often / 10)
        burst = random.index(20);
      const bool overran = burst > 0 || random.uniform(0, 1) < often;
      const TopicSet due = (i % 17 == 0 ? kNeedle : 0) | (i % 33 == 0 ? kTissue : 0);
      tick(thinning, due, overran);
      late += overran ? 1 : 0;
      left_out += thinning.left_out() ? 1 : 0;
    }
    CHECK(left_out <= 3 * late);
  }
}

}  // namespace acus
