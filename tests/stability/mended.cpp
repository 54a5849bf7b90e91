// SPDX-License-Identifier: GPL-3.0-or-later
// Runs that went wrong before steps were looked at, and one that never did.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "tests/study/studies/stability_cases.h"
#include "tests/study/studies/stability_run.h"
#include "tests/support/temporary_folder.h"

using namespace acus;

namespace {

Experiment experiment_of(const std::string& first, const std::string& partner = "") {
  static const TemporaryFolder meshes;
  const StabilityRun run{&stability_case(first), partner.empty() ? nullptr : &stability_case(partner)};
  return make_experiment(make_trial(run), meshes.path());
}

struct Shown {
  StabilitySeries series;
  StabilityFigures figures;

  bool flagged(std::uint32_t flag) const {
    return std::any_of(series.flags.begin(), series.flags.end(), [=](std::uint32_t f) { return (f & flag) != 0; });
  }
};

Shown run(const std::string& first, const std::string& partner = "") {
  Shown shown{run_to_rest(experiment_of(first, partner)), {}};
  shown.figures = measure(shown.series);
  CHECK(shown.series.finite);
  CHECK(!shown.flagged(kNotFinite));
  return shown;
}

}  // namespace

TEST_CASE("the base trial is sound without a flag") {
  const Shown base = run("base");
  CHECK(!base.flagged(~0u));
  CHECK(base.series.withdrawn);
  CHECK(base.series.deepest > 0.03);
  CHECK(judge(base.series, base.figures, 1e-6).outcome == TrialOutcome::sound);
}

// Linearised once, the needle's bend was stretched by kilojoules.
TEST_CASE("a base that jumps aside makes no energy") {
  const Shown jump = run("base jumps 100 mm aside");
  CHECK(jump.figures.gain.value < 1e-3);
}

// A needle that sticks in stone buckles; each snap used to make hundreds of joules.
TEST_CASE("a needle that buckles takes steps that it can answer for") {
  const Shown buckled = run("tissue E 1 GPa");
  CHECK(buckled.flagged(kTangentProjected));
  CHECK(buckled.figures.gain.value < 1e-3);
}

// Whirling in the air and at the surface, above the first frequency of its bending.
TEST_CASE("a wire that whirls faster than ticks can follow is told of") {
  const Shown wire = run("diameter 0.1 mm", "50 turns a second");
  CHECK(wire.flagged(kEnergyGained));
}

// A short needle that sticks in stone and is pushed on.
TEST_CASE("a needle that is stretched beyond what its beams describe is told of") {
  CHECK(run("tissue E 1 GPa", "path longer than the needle").flagged(kNeedleOverstrained));
}

// Its path ran across the needle, which was stretched along it as far as the path's vertex ran away.
TEST_CASE("a path that runs across the needle does not pull along it") {
  const Shown across = run("tissue E 1 GPa", "mu 10");
  CHECK(across.figures.gain.value < 1e-3);
}

// The pressure of crushed elements makes them stiffer against turning than the rest shape's matrix: steps grew without
// bound.
TEST_CASE("crushed tissue near nu = 0.5 stays bounded at long ticks") {
  const Shown crushed = run("nu 0.4999", "h 100 ms");
  CHECK(crushed.figures.gain.value < 1e-3);
}

TEST_CASE("a plate that a tip drives through its supports stays bounded") {
  const Shown plate = run("f_p infinite", "entry and exit in one tick");
  CHECK(plate.figures.gain.value < 1e-3);
}

// Damping of the elements as they stood at the start of the tick, against a matrix of what became of them.
TEST_CASE("repeated steps of a tissue that collapses go down") {
  const Experiment experiment = experiment_of("gravity times 100", "rung refined");
  Simulation simulation(experiment.scene);
  const double start = simulation.energy().total();
  for (int k = 0; k < 40; ++k) {
    simulation.step();
    CHECK(simulation.energy().total() < start + 1e-3);
  }
  CHECK((simulation.report().flags & kElementsInverted) != 0);
}

TEST_CASE("elements that are turned inside out are told of") {
  const Shown crushed = run("crushed by a rigid needle");
  CHECK(crushed.series.smallest_volume < 0);
  CHECK(crushed.flagged(kElementsInverted));
  CHECK(!crushed.series.unseen_inversion);
}

TEST_CASE("a tip that starts inside the tissue is refused") {
  const Experiment experiment = experiment_of("starts wholly inside");
  CHECK_THROWS_WITH_AS(run_to_rest(experiment), doctest::Contains("needles[0].base"), SceneError);
}
