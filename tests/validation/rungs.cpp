// SPDX-License-Identifier: GPL-3.0-or-later
// Every rung of the tissue against the reference, rung `exact`, and against the rungs beside it.
#include <doctest/doctest.h>

#include <algorithm>

#include "server/engine/scene/scene_fields.h"
#include "tests/validation/insertion_run.h"

namespace acus::test {
namespace {

const std::vector<Leg> kInAndOut{{0.05, 0.04, 0.1}, {0.03, 0.04, 0.1}, {0.055, 0.04, 0.1}, {-0.005, 0.04, 0.1}};

Scene on_rung(Scene scene, TissueRung rung) {
  scene.tissue.rung = rung;
  return scene;
}

// Solved further than a scene would ask, so that differences are the rungs' own.
Scene strict_scene() {
  Scene scene = coarse_scene();
  scene.laws.tolerance = 1e-8;
  scene.laws.max_steps = 20000;
  scene.newton.tolerance = 1e-10;
  return scene;
}

std::uint64_t puncture_tick(const InsertionRun& run) {
  const Event* e = run.find(EventKind::puncture);
  return e == nullptr ? 0 : e->tick;
}

// The largest differences of two runs. Between the two punctures one needle is through and the other is not: the
// drop from f_p to f_c falls into different ticks, and no bound on the difference there says anything.
struct Difference {
  Difference(const InsertionRun& run, const InsertionRun& exact) {
    REQUIRE(run.samples().size() == exact.samples().size());
    const std::uint64_t first = std::min(puncture_tick(run), puncture_tick(exact));
    const std::uint64_t last = std::max(puncture_tick(run), puncture_tick(exact));
    REQUIRE(first > 0);
    puncture = last - first;
    double peak = 0;
    for (std::size_t i = 0; i < exact.samples().size(); ++i) {
      const NeedleReport& a = run.samples()[i].report.needles[0];
      const NeedleReport& b = exact.samples()[i].report.needles[0];
      const std::uint64_t tick = exact.samples()[i].report.tick;
      peak = std::max(peak, b.base_force.norm());
      tip = std::max(tip, (a.tip_position - b.tip_position).norm());
      if (tick < first || tick > last) force = std::max(force, (a.base_force - b.base_force).norm());
    }
    force /= peak;
  }

  std::uint64_t puncture = 0;  // ticks
  double force = 0;            // -, of the base, over the largest
  double tip = 0;              // m
};

// What an insertion of 30 mm ends with.
struct Outcome {
  bool punctured;
  Sample last;
};

Outcome insert(NeedleRung needle, TissueRung tissue) {
  Scene scene = on_rung(coarse_scene(), tissue);
  scene.needles[0].rung = needle;
  InsertionRun run(scene);
  run.run({{0.04, 0.04, 0.1}});
  return {run.find(EventKind::puncture) != nullptr, run.last()};
}

}  // namespace

TEST_CASE("rung warped follows rung exact, and rung refined ends where it does" * doctest::test_suite("full")) {
  const Scene scene = strict_scene();
  InsertionRun exact(on_rung(scene, TissueRung::exact)), warped(on_rung(scene, TissueRung::warped)),
      refined(on_rung(scene, TissueRung::refined));
  for (InsertionRun* run : {&exact, &warped, &refined}) run->run(kInAndOut);
  const Difference of_warped(warped, exact), of_refined(refined, exact);
  MESSAGE("warped: base force differs by " << 100 * of_warped.force << " % of its peak, tip by " << 1e3 * of_warped.tip
                                           << " mm; refined: by " << 100 * of_refined.force << " %");
  CHECK(of_warped.puncture <= 1);
  CHECK(of_warped.force < 0.015);  // 0.0034 measured
  CHECK(of_warped.tip < 6e-5);
  CHECK(of_refined.puncture == 0);
  CHECK(of_refined.force < 2e-7);
  CHECK(of_refined.tip < 4e-10);
}

// Its last iterations move the tissue by more than the scene's tolerance, and hardly change a force.
TEST_CASE("rung refined balances forces at Poisson's ratio 0.499, with the element that does not lock" *
          doctest::test_suite("gate")) {
  Scene scene = on_rung(coarse_scene(), TissueRung::refined);
  scene.tissue.element = TissueElement::nodal_pressure;
  scene.tissue.regions[0].material.poisson_ratio = 0.499;
  InsertionRun run(scene);
  std::uint32_t flags = 0;
  int iterations = 0;
  double imbalance = 0, largest = 0;
  run.run({{0.04, 0.04, 0.1}, {-0.005, 0.04, 0.1}}, [&](const Sample& s) {
    flags |= s.report.flags;
    iterations = std::max(iterations, s.report.newton_iterations);
    imbalance = std::max(imbalance, s.report.imbalance);
    largest = std::max(largest, s.report.largest_force);
  });
  REQUIRE(run.find(EventKind::puncture) != nullptr);
  REQUIRE(run.find(EventKind::withdrawal) != nullptr);
  MESSAGE("at most " << iterations << " iterations, imbalance " << imbalance << " of " << largest << " N");
  CHECK((flags & ~std::uint32_t{kNewtonNotConverged}) == 0);
  CHECK(imbalance < 1e-5 * largest);
}

TEST_CASE("rung linear is rung warped while the tissue hardly moves") {
  // The tip presses the surface in by a few micrometres.
  Scene scene = strict_scene();
  scene.needles[0].base.position.z() -= 0.01 - 1e-6;
  const auto press = [&](TissueRung rung) {
    InsertionRun run(on_rung(scene, rung));
    run.run({{1.5e-5, 1e-3, 0.1}});
    return run.last().report.needles[0];
  };
  const NeedleReport linear = press(TissueRung::linear), warped = press(TissueRung::warped);
  CHECK(linear.phase == Phase::contact);
  CHECK(warped.base_force.norm() > 1e-4);
  CHECK((linear.base_force - warped.base_force).norm() < 3e-4 * warped.base_force.norm());
}

TEST_CASE("rung linear inserts a needle") {
  const Outcome linear = insert(NeedleRung::flexible, TissueRung::linear);
  const Outcome warped = insert(NeedleRung::flexible, TissueRung::warped);
  CHECK(linear.punctured);
  CHECK(linear.last.resistance == doctest::Approx(warped.last.resistance).epsilon(1.5e-3).scale(0));
}

TEST_CASE("a rigid needle goes with every rung of the tissue" * doctest::test_suite("full")) {
  const double expected = insert(NeedleRung::rigid, TissueRung::warped).last.resistance;
  for (const TissueRung rung : {TissueRung::linear, TissueRung::refined, TissueRung::exact}) {
    CAPTURE(name_of(rung));
    const Outcome outcome = insert(NeedleRung::rigid, rung);
    CHECK(outcome.punctured);
    CHECK(outcome.last.resistance == doctest::Approx(expected).epsilon(2e-3).scale(0));
  }
  const Outcome alone = insert(NeedleRung::rigid, TissueRung::none);
  CHECK(alone.last.report.rows == 0);
  CHECK(alone.last.resistance == doctest::Approx(0));
}

}  // namespace acus::test
