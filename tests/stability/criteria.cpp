// SPDX-License-Identifier: GPL-3.0-or-later
// The measures of stability on series that are made up.
#include "tests/study/studies/stability_criteria.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "tests/study/studies/stability_run.h"

using namespace acus;

namespace {

constexpr int kTicks = 400;

template <class Value>
std::vector<double> series(Value value) {
  std::vector<double> all;
  for (int k = 0; k < kTicks; ++k) all.push_back(value(k));
  return all;
}

template <class Value>
std::vector<Vector3> forces(Value value) {
  std::vector<Vector3> all;
  for (int k = 0; k < kTicks; ++k) all.push_back({value(k), 0.5 * value(k), 1});
  return all;
}

// A run that nothing is wrong with: pushed until tick 200, the needle out at tick 250, then the tissue comes to rest.
StabilitySeries quiet_run() {
  StabilitySeries s;
  s.work = series([](int k) { return 0.01 * std::min(k, 200); });
  s.stored = series([](int k) { return k < 200 ? 0.008 * k : 1.6 * std::exp(-0.05 * (k - 200)); });
  s.kinetic = series([](int k) { return 0.1 * std::exp(-0.05 * k); });
  s.distance = series([](int k) { return k < 200 ? 1e-5 * k : 2e-3 * std::exp(-0.05 * (k - 200)); });
  s.residual = series([](int) { return 1e-9; });
  s.flags.assign(kTicks, 0);
  s.forces = {forces([](int k) { return std::sin(0.1 * k); })};
  s.rest = 200;
  s.last_inside = 250;
  s.touched = true;
  s.withdrawn = true;
  return s;
}

Verdict verdict_of(const StabilitySeries& s) { return judge(s, measure(s), 1e-6); }

}  // namespace

TEST_CASE("a quiet run is sound") {
  const Verdict verdict = verdict_of(quiet_run());
  CHECK(verdict.outcome == TrialOutcome::sound);
  CHECK(verdict.why.empty());
}

TEST_CASE("alternation is the least of six opposed increments over the mean force") {
  const auto f = forces([](int k) { return k > 100 && k <= 120 ? (k % 2 ? 0.2 : -0.2) : 0.0; });
  const Peak peak = alternation(f);
  const double increment = 0.4 * std::hypot(1, 0.5), force = std::hypot(0.2, 0.1, 1);
  CHECK(peak.value == doctest::Approx(increment / force));
  CHECK(peak.tick > 100);
  CHECK(peak.tick <= 121);
}

TEST_CASE("fewer alternations, smooth swings and steps are none") {
  CHECK(alternation(forces([](int k) { return k > 100 && k <= 104 ? (k % 2 ? 0.2 : -0.2) : 0.0; })).value == 0);
  CHECK(alternation(forces([](int k) { return std::sin(0.5 * k); })).value == 0);
  CHECK(alternation(forces([](int k) { return k < 100 ? 0.0 : 5.0; })).value == 0);
}

TEST_CASE("alternation of forces too small to matter is none") {
  std::vector<Vector3> f;
  for (int k = 0; k < kTicks; ++k) f.push_back({0, 0, k % 2 ? 1e-6 : -1e-6});
  CHECK(alternation(f).value == 0);
}

TEST_CASE("energy that no work paid for is a gain, relative to the larger of both") {
  const auto work = series([](int k) { return 0.01 * k; });
  CHECK(energy_gain(work, work).value == doctest::Approx(0).epsilon(1e-12));
  const auto stored = series([](int k) { return 0.01 * k + (k == 300 ? 1.0 : 0.0); });
  const Peak peak = energy_gain(stored, work);
  CHECK(peak.tick == 300);
  CHECK(peak.value == doctest::Approx(1 / 4.0));  // of 4 J at tick 300
}

TEST_CASE("a rise is counted from the least before it, after the commands only, and less the work of the base") {
  const auto stored = series([](int k) { return 2.0 - 0.004 * k + (k >= 350 ? 0.1 : 0.0) + (k == 50 ? 0.5 : 0.0); });
  const std::vector<double> none(kTicks, 0.0);
  const double scale = 2.0 - stored.back();
  CHECK(energy_rise(stored, none, 100).value == doctest::Approx(0.096 / scale));
  CHECK(energy_rise(stored, none, 100).tick == 350);
  const auto paid = series([](int k) { return k >= 350 ? 0.1 : 0.0; });
  CHECK(energy_rise(stored, paid, 100).value == doctest::Approx(0));
}

TEST_CASE("a residual counts where the tick does not own up to it") {
  auto s = quiet_run();
  s.residual[70] = 1e-3;
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
  s.flags[70] = kLawsNotConverged;
  CHECK(verdict_of(s).outcome == TrialOutcome::flagged);
  s.residual[71] = 1e-3;  // the flag of a tick before excuses nothing
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
}

TEST_CASE("what a tick flags shortly before is told, not hidden; energy without bound is a failure all the same") {
  auto s = quiet_run();
  s.stored[150] += 0.5;
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
  s.flags[150 - kExcused - 1] = kStepLimited;
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
  s.flags[145] = kStepLimited;
  CHECK(verdict_of(s).outcome == TrialOutcome::flagged);
  s.stored[150] += 1e6;
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
}

TEST_CASE("a tissue that stands still off its place has not returned, one that swings is on its way") {
  auto s = quiet_run();
  s.distance.back() = 1e-3;
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
  s.withdrawn = false;
  CHECK(judge(s, measure(s), 1e-6, {.come_out = false}).outcome == TrialOutcome::sound);  // the needle holds it
  s.withdrawn = true;
  s.kinetic = series([](int k) { return 1 + std::sin(0.1 * k); });
  CHECK(verdict_of(s).outcome == TrialOutcome::sound);
}

TEST_CASE("what is not finite fails whatever the flags are") {
  auto s = quiet_run();
  s.finite = false;
  s.flags.assign(kTicks, kNotFinite);
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
}

TEST_CASE("a tick that was held because it was not finite fails, though all that is reported is finite") {
  auto s = quiet_run();
  s.flags[70] = kNotFinite;
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
}

TEST_CASE("energy that is no number is neither sound nor excused") {
  auto s = quiet_run();
  s.stored[70] = std::nan("");
  s.finite = false;
  CHECK(std::isnan(energy_gain(s.stored, s.work).value));
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
}

TEST_CASE("a run with a trouble is flagged though its figures are good, and most of its ticks only if they are") {
  auto s = quiet_run();
  s.flags[70] = kElementsInverted;
  CHECK(verdict_of(s).outcome == TrialOutcome::flagged);
  CHECK(verdict_of(s).why.empty());
  CHECK(measure(s).excused == doctest::Approx((kExcused + 1.0) / kTicks));
  s.stored[150] += 0.5;
  CHECK(verdict_of(s).why == "energy gain");
  s.flags.assign(kTicks, kElementsInverted);
  CHECK(verdict_of(s).why == "energy gain; most ticks are flagged");
}

TEST_CASE("an alternation that is told of does not hide a smaller one that is not") {
  auto s = quiet_run();
  const auto shake = [&](int from, double by) {
    for (int k = from; k < from + 20; ++k) s.forces[0][k] += Vector3::Constant(k % 2 ? by : -by);
  };
  shake(50, 0.8);
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
  s.flags[45] = kStepLimited;
  CHECK(verdict_of(s).outcome == TrialOutcome::flagged);
  shake(250, 0.4);
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
}

TEST_CASE("a run that shows nothing fails unless it may") {
  auto s = quiet_run();
  s.withdrawn = false;
  CHECK(verdict_of(s).why == "needle does not come out");
  CHECK(verdict_of(s).outcome == TrialOutcome::failed);
  s.flags.back() = kElementsInverted;
  CHECK(verdict_of(s).outcome == TrialOutcome::flagged);
  s.flags.back() = 0;
  s.touched = false;
  s.withdrawn = true;
  CHECK(verdict_of(s).why == "needle never touches the tissue");
  CHECK(judge(s, measure(s), 1e-6, {.touch = false}).outcome == TrialOutcome::sound);
  CHECK(judge(s, measure(s), 1e-6, {.touch = false}).why == "needle never touches the tissue");
}

TEST_CASE("a rigid motion is no distance") {
  Matrix3X x = Matrix3X::Random(3, 20);
  const Eigen::AngleAxisd turn(0.7, Vector3(1, 2, 3).normalized());
  const Matrix3X moved = (turn.toRotationMatrix() * x).colwise() + Vector3(4, 5, 6);
  CHECK(distance_but_for_rigid_motion(moved, x) < 1e-12);
  x.col(3) += Vector3(0.1, 0, 0);
  CHECK(distance_but_for_rigid_motion(moved, x) > 0.05);
}
