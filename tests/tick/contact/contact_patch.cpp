// SPDX-License-Identifier: GPL-3.0-or-later
// What bears a contact: points of the surface around it.
#include "server/engine/tick/contact/contact_patch.h"

#include <doctest/doctest.h>

#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {
namespace {

ContactPatch patch_at(InsertionBench& bench, const Vector3& p, double radius) {
  const TissueView tissue = bench.view().tissue;
  return make_contact_patch(tissue, tissue.surface, bench.point(p), radius);
}

double share_of(const ContactPatch& patch) {
  double sum = 0;
  for (const MaterialPoint& point : patch.points) sum += point.weights.sum();
  return sum;
}

}  // namespace

TEST_CASE("on a flat surface the shares are equal, sum to one, and lie around the contact") {
  InsertionBench bench;
  const double radius = 5e-3;
  const ContactPatch patch = patch_at(bench, on_line(kTop), radius);
  CHECK(share_of(patch) == doctest::Approx(1).epsilon(1e-12));
  CHECK((patch.middle - on_line(kTop)).norm() < kRounding);
  CHECK((patch.normal - Vector3::UnitZ()).norm() < kRounding);
  CHECK(std::abs(patch.rise) < kRounding);
  double moment = 0;  // of an even load on a disc: half its radius squared
  for (MaterialPoint point : patch.points) {
    const double share = point.weights.sum();
    CHECK(share == doctest::Approx(1.0 / kPatchPoints).epsilon(1e-9));
    point.weights /= share;
    const Vector3 place = bench.position(point);
    CHECK(place.z() == doctest::Approx(kTop).epsilon(1e-9));
    moment += share * (place - on_line(kTop)).squaredNorm();
  }
  CHECK(moment == doctest::Approx(radius * radius / 2).epsilon(0.01));
}

TEST_CASE("beside an edge the tissue that is there bears nearly all, and the contact stands over the mean") {
  InsertionBench bench;
  const Vector3 beside(kTop - 1e-3, 2e-3, kTop);  // 1 mm from the edge of the cube's top
  const double radius = 8e-3;
  const ContactPatch patch = patch_at(bench, beside, radius);
  CHECK(share_of(patch) == doctest::Approx(1).epsilon(1e-12));
  double beyond = 0;  // share of the points that were brought back to the edge
  for (const MaterialPoint& point : patch.points) {
    MaterialPoint alone = point;
    alone.weights /= point.weights.sum();
    if (bench.position(alone).x() > kTop - 1e-6) beyond += point.weights.sum();
  }
  CHECK(beyond < 0.2);
  CHECK(patch.middle.x() < beside.x());
  CHECK((patch.normal - Vector3::UnitZ()).norm() < kRounding);
}

TEST_CASE("past an edge the side of the body does not bear, wherever rounding puts the contact") {
  InsertionBench bench;
  const Vector3 beside(kTop - 1e-3, 2e-3, kTop);
  for (int i = 0; i < 50; ++i) {
    const double step = 1e-15 * (i * i % 17 - 8);
    const ContactPatch patch = patch_at(bench, beside + Vector3(step, -3 * step, 0), 8e-3);
    CHECK((patch.normal - Vector3::UnitZ()).norm() < kRounding);
  }
}

TEST_CASE("a patch wider than the tissue is as good as one of all its face") {
  InsertionBench bench;
  const ContactPatch patch = patch_at(bench, on_line(kTop), 0.5);
  CHECK(share_of(patch) == doctest::Approx(1).epsilon(1e-12));
  CHECK((patch.normal - Vector3::UnitZ()).norm() < kRounding);
}

TEST_CASE("inside it lies on the border, its points in the tissue before it") {
  InsertionBench bench(two_regions(0.7));
  const TissueView tissue = bench.view().tissue;
  const MaterialPoint centre = bench.border_point(kLower, on_line(0));
  const ContactPatch patch = make_contact_patch(tissue, tissue.borders.surface(kLower), centre, 5e-3);
  CHECK(share_of(patch) == doctest::Approx(1).epsilon(1e-12));
  CHECK((patch.middle - on_line(0)).norm() < kRounding);
  CHECK((patch.normal - Vector3::UnitZ()).norm() < kRounding);
  for (const MaterialPoint& point : patch.points) CHECK(tissue.region(point) == kUpper);
}

}  // namespace acus::test
