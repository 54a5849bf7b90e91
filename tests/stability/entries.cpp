// SPDX-License-Identifier: GPL-3.0-or-later
// Needles that go in anywhere (tests/study/studies/entries.h): a few of them in every run of the tests.
#include "tests/study/studies/entries.h"

#include <doctest/doctest.h>

#include <cmath>

namespace acus {

TEST_CASE("no needle is a ghost, and where no edge is near it punctures at f_p" * doctest::test_suite("full")) {
  int flat = 0, at_force = 0;
  for (int number = 0; number < 24; ++number) {
    const Entry entry = random_entry(number, {});
    if (entry.scene.tissue.rung == TissueRung::refined) continue;  // takes ten times as long; in the report
    CAPTURE(number);
    const EntryOutcome outcome = run_entry(entry);
    CHECK(outcome.touched);
    CHECK_FALSE(outcome.ghost());
    // Its path comes out where elements are pressed flat, and others fold over the tip.
    CHECK((outcome.found_inside == 0 || outcome.inverted_ticks > 0));
    if (entry.support < 1 || entry.ratio > 5) continue;
    const double f_p = entry.scene.tissue.regions[0].interaction.puncture_force;
    ++flat;
    at_force += outcome.punctured && std::abs(outcome.puncture_force - f_p) < 0.02 * f_p;
  }
  REQUIRE(flat >= 8);
  CHECK(at_force == flat);
}

TEST_CASE("the same number gives the same entry") {
  const Entry a = random_entry(3, {}), b = random_entry(3, {});
  CHECK(a.at == b.at);
  CHECK(a.along == b.along);
  CHECK(a.scene.rate == b.scene.rate);
  CHECK(a.scene.tissue.regions[0].material.young_modulus == b.scene.tissue.regions[0].material.young_modulus);
}

}  // namespace acus
