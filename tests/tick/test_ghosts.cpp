// SPDX-License-Identifier: GPL-3.0-or-later
// A needle in the tissue is in a path or in contact: never one that passes through and feels nothing.
#include <doctest/doctest.h>

#include <string>

#include "server/engine/math/random.h"
#include "server/engine/models/geometry/surface.h"
#include "tests/study/studies/ghosts.h"
#include "tests/support/places.h"
#include "tests/tick/bench.h"

namespace acus::test {

namespace {

struct Outcome {
  int unnoticed = 0;       // ticks that ended with a ghost
  bool flagged = false;
  bool punctured = false;  // by a force within 2 % of what the scene says
  double force_at_depth = 0;  // N, mean resistance once the tip is 10 mm deep
};

// Pushes the needle of shipped scene `liver_insertion` straight down at (x, y).
Outcome push_into_liver(double x, double y, double speed) {
  Scene scene = read_scene(source_path("scenes/liver_insertion.yaml"));
  scene.needles[0].base.position.x() = x;
  scene.needles[0].base.position.y() = y;
  Bench bench(scene);
  const Surface surface(bench.simulation().mesh());
  Outcome outcome;
  bench.each_tick = [&] {
    outcome.unnoticed += is_ghost(bench.simulation(), surface, 0) ? 1 : 0;
    outcome.flagged = outcome.flagged || bench.simulation().report().flags & kTipFoundInside;
  };
  bench.push(0, 0.03, speed);
  const double f_p = scene.tissue.regions[0].interaction.puncture_force;
  for (const Event& event : bench.events(EventKind::puncture))
    outcome.punctured = outcome.punctured || std::abs(event.force - f_p) < 0.02 * f_p;
  outcome.force_at_depth = bench.resistance();
  return outcome;
}

}  // namespace

// On a point of this mesh the puncture force would turn elements inside out.
TEST_CASE("a tip on elements that a point force would crush keeps its contact, and punctures") {
  const Outcome outcome = push_into_liver(0.29e-3, 8.17e-3, 0.04);
  CHECK_FALSE(outcome.flagged);
  CHECK(outcome.punctured);
  CHECK(outcome.unnoticed == 0);
  CHECK(outcome.force_at_depth > 0.1);
}

TEST_CASE("no needle is a ghost, wherever it goes in" * doctest::test_suite("gate")) {
  Random random(41);
  for (int i = 0; i < 12; ++i) {
    const double x = random.uniform(-0.02, 0.02), y = random.uniform(-0.02, 0.02), speed = random.uniform(0.01, 0.1);
    CAPTURE(x);
    CAPTURE(y);
    CAPTURE(speed);
    const Outcome outcome = push_into_liver(x, y, speed);
    CHECK(outcome.unnoticed == 0);
    CHECK_FALSE(outcome.flagged);
    CHECK(outcome.punctured);
    CHECK(outcome.force_at_depth > 0.1);
  }
}

}  // namespace acus::test
