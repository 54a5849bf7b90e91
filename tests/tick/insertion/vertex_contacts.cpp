// SPDX-License-Identifier: GPL-3.0-or-later
// The contacts, and their rows, of the vertex at 22 mm of a straight path, with the tip at 12 mm: it owns 4 mm of
// shaft.
#include <doctest/doctest.h>

#include <numbers>

#include "server/engine/tick/insertion/finding/vertex_contacts.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {
namespace {

constexpr int kVertex = 2;
constexpr double kOwned = 4e-3;                                          // m
constexpr double kNormal = kOwned * std::numbers::pi * kDiameter * 6e3;  // N, l pi d p
const Vector3 kBeside(5e-4, -3e-4, 0);                                   // m, of the needle off its path

bool add_vertex(InsertionBench& bench) {
  return bench.add_rows([&] {
    find_vertex_contacts(bench.view(), bench.paths[0], bench.scratch, bench.scratch.located.shaft[kVertex],
                         bench.contacts);
  });
}

// The rows at the needle where it is; it came from `back` (m) behind.
Rows& rows_of(InsertionBench& bench, double back = 0, double spin = 0) {
  bench.add_straight_path(0.012);
  bench.be_in_path(0);
  bench.put_needle(on_line(0.012 + back) + kBeside);
  bench.move_needle(on_line(0.012) + kBeside, -Vector3::UnitZ(), spin);
  const Located& located = bench.locate();
  REQUIRE(located.shaft.size() == 5);
  REQUIRE(located.shaft[kVertex].owned == doctest::Approx(kOwned).epsilon(1e-9));
  CHECK(add_vertex(bench));
  return bench.rows;
}

void remember(InsertionBench& bench, bool slips) {
  for (VertexState& vertex : bench.scratch.next.vertices) vertex.contact.sliding = slips;
}

}  // namespace

TEST_CASE("two lateral rows stand across the path and hold the needle's offset") {
  InsertionBench bench;
  const Rows& rows = rows_of(bench);
  REQUIRE(rows.count() == 3);
  const Row &a = rows.row(0), &b = rows.row(1);
  CHECK(bench.contacts.found[0].kind == ContactKind::vertex);
  CHECK(bench.contacts.found[0].state == &bench.scratch.next.vertices[kVertex].contact);
  CHECK(a.n.norm() == doctest::Approx(1).epsilon(1e-12));
  CHECK(b.n.norm() == doctest::Approx(1).epsilon(1e-12));
  CHECK(std::abs(a.n.dot(b.n)) < 1e-12);
  CHECK(std::abs(a.n.z()) < 1e-12);
  CHECK(std::abs(b.n.z()) < 1e-12);
  CHECK((a.gap * a.n + b.gap * b.n - kBeside).norm() < kRounding);
  CHECK(rows.law(0).kind == LawKind::bilateral);
  CHECK(rows.law(0).compliance == doctest::Approx(1 / (50e3 * kOwned)).epsilon(1e-9));  // 1/(k l)
}

TEST_CASE("friction runs along the path, on what the needle moved against the tissue in the tick") {
  InsertionBench bench;
  const Rows& rows = rows_of(bench, 2e-4);
  const Row& friction = rows.row(2);
  CHECK((friction.n + Vector3::UnitZ()).norm() < 1e-12);
  CHECK(friction.gap == doctest::Approx(2e-4).epsilon(1e-8));
  CHECK(rows.law(2).kind == LawKind::friction);
  CHECK(rows.law(2).viscosity == 0);
}

TEST_CASE("the friction threshold is l pi d mu p, static where it stuck, dynamic where it slid") {
  InsertionBench bench;
  rows_of(bench);
  CHECK(bench.rows.law(2).limit == doctest::Approx(0.3 * kNormal).epsilon(1e-9));  // a new vertex slides
  bench.rows.clear();
  remember(bench, false);
  add_vertex(bench);
  CHECK(bench.rows.law(2).limit == doctest::Approx(0.35 * kNormal).epsilon(1e-9));
}

TEST_CASE("strain stays as the owned length changes, but a spring that is drawn out far and sticks bears no more") {
  InsertionBench bench;
  rows_of(bench);
  VertexState& state = bench.scratch.next.vertices[kVertex];
  const double axial = bench.view().tissue.axial_compliance(bench.paths[0].vertices[kVertex], kDiameter);
  REQUIRE(axial > 0);
  const auto strained = [&](bool slips, double drawn, double force_before) {
    state.contact.sliding = slips;
    state.traction = drawn / axial;
    state.contact.along = force_before * state.traction * kOwned;
    bench.rows.clear();
    add_vertex(bench);
    const Row& friction = bench.rows.row(2);
    CHECK(friction.compliance == doctest::Approx(axial / kOwned).epsilon(1e-9));
    return -friction.gap / friction.compliance / (state.traction * kOwned);
  };
  CHECK(strained(false, 0.2 * kOwned, 0.8) == doctest::Approx(1).epsilon(1e-9));
  CHECK(strained(true, 0.3 * kOwned, 0.8) == doctest::Approx(1).epsilon(1e-9));
  CHECK(strained(false, 0.3 * kOwned, 0.8) == doctest::Approx(0.8).epsilon(1e-9));
  CHECK(strained(false, 0.3 * kOwned, 1.2) == doctest::Approx(1).epsilon(1e-9));
}

TEST_CASE("viscous friction is b l over the tick") {
  Scene scene = one_region();
  scene.tissue.regions[0].interaction.friction_viscous = 12;
  InsertionBench bench(scene);
  CHECK(rows_of(bench).law(2).viscosity == doctest::Approx(12 * kOwned / kH).epsilon(1e-9));
}

TEST_CASE("without friction a vertex has no row along the path, with viscosity alone it has one") {
  Scene scene = one_region();
  Interaction& law = scene.tissue.regions[0].interaction;
  law.friction_static = law.friction_dynamic = 0;
  int rows = 2;
  SUBCASE("none") {}
  SUBCASE("viscous") {
    law.friction_viscous = 12;
    rows = 3;
  }
  InsertionBench bench(scene);
  CHECK(rows_of(bench).count() == rows);
}

TEST_CASE("torsion is on the surface of the needle, in one cone with the friction along it") {
  Scene scene = one_region();
  scene.needles[0].torsional_friction = 0.5;
  InsertionBench bench(scene);
  const Rows& rows = rows_of(bench, 0, 0.02);
  REQUIRE(rows.count() == 4);
  const Row& torsion = rows.row(3);
  CHECK(torsion.turns());
  CHECK(torsion.radius == 0.5 * kDiameter / 2);
  CHECK((torsion.n + Vector3::UnitZ()).norm() < 1e-12);
  CHECK(torsion.gap == doctest::Approx(0.02 * 0.5 * kDiameter / 2).epsilon(1e-8));
  const Rows::Cone* cone = rows.find_cone(2);
  REQUIRE(cone);
  CHECK(cone->friction.law.threshold == doctest::Approx(0.3 * kNormal).epsilon(1e-9));
}

TEST_CASE("friction that thins, or differs on the way back, is a cone of one row") {
  Scene scene = one_region();
  Interaction& law = scene.tissue.regions[0].interaction;
  law.friction_viscous = 12;
  SUBCASE("plain") {
    InsertionBench bench(scene);
    CHECK_FALSE(rows_of(bench).find_cone(2));
  }
  SUBCASE("thins") {
    law.friction_thinning_speed = 2e-3;
    law.friction_exponent = 0.4;
    InsertionBench bench(scene);
    const Rows::Cone* cone = rows_of(bench).find_cone(2);
    REQUIRE(cone);
    CHECK_FALSE(cone->turns);
    CHECK(cone->friction.law.viscosity == doctest::Approx(12 * kOwned / kH).epsilon(1e-9));
    CHECK(cone->friction.law.thinning == doctest::Approx(2e-3 * kH).epsilon(1e-12));
    CHECK(cone->friction.law.exponent == 0.4);
  }
  SUBCASE("back") {
    law.friction_back = 0.3;
    InsertionBench bench(scene);
    const Rows::Cone* cone = rows_of(bench).find_cone(2);
    REQUIRE(cone);
    CHECK(cone->friction.back == 0.3);
  }
}

}  // namespace acus::test
