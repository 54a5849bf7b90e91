// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/errors.h"

#include <doctest/doctest.h>

#include <cmath>

namespace acus {
namespace {

// A needle whose tip is at (t, 0, 0) and whose base bears (0, 2, 0) N, a probe that is at (0, 0, 3); for one second.
Recording steady(double h) {
  Recording r;
  r.h = h;
  const auto ticks = static_cast<Eigen::Index>(std::lround(1 / h));
  r.tip.push_back(Matrix3X::Zero(3, ticks));
  for (Eigen::Index k = 0; k < ticks; ++k) r.tip[0](0, k) = static_cast<double>(k + 1) * h;
  r.base_force.push_back(Matrix3X::Zero(3, ticks));
  r.base_force[0].row(1).setConstant(2);
  r.probes.assign(10, Matrix3X::Zero(3, 1));
  for (Matrix3X& probe : r.probes) probe(2, 0) = 3;
  r.ticks = static_cast<std::uint64_t>(ticks);
  return r;
}

TEST_CASE("a run does not differ from itself") {
  const Errors e = errors(steady(0.1), steady(0.1));
  for (const Deviation& d : {e.tip, e.force, e.tissue}) {
    CHECK(d.max == 0);
    CHECK(d.rms == 0);
  }
}

TEST_CASE("a reference with other ticks is compared at the same times") {
  CHECK(errors(steady(0.1), steady(0.025)).tip.max < 1e-15);
  CHECK(errors(steady(0.1), steady(1.0 / 30)).tip.max < 1e-15);
}

TEST_CASE("maximum and root mean square are of the lengths of differences, over time") {
  Recording run = steady(0.1);
  run.base_force[0].col(4) += Vector3(0.3, 0, 0.4);
  run.probes[1](0, 0) = 0.2;
  const Errors e = errors(run, steady(0.1));
  CHECK(e.force.max == doctest::Approx(0.5));
  CHECK(e.force.rms == doctest::Approx(0.5 / std::sqrt(10)));
  CHECK(e.tissue.max == doctest::Approx(0.2));
  CHECK(e.tissue.rms == doctest::Approx(0.2 / std::sqrt(10)));
  CHECK(e.force.p95 == 0);
  CHECK(e.tip.max == 0);
}

TEST_CASE("magnitudes are of forces and displacements as they are, and of the tip's way") {
  const Errors size = magnitudes(steady(0.1));
  CHECK(size.force.max == doctest::Approx(2));
  CHECK(size.tissue.max == doctest::Approx(3));
  CHECK(size.tip.max == doctest::Approx(0.9));
}

}  // namespace
}  // namespace acus
