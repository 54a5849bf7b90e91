// SPDX-License-Identifier: GPL-3.0-or-later
// The contacts of the tip, and their rows: on the surface, at the end of its path, back inside it, at a border.
#include <doctest/doctest.h>

#include "server/engine/tick/insertion/finding/tip_contacts.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {
namespace {

void check_across(const Row& a, const Row& b, const Vector3& direction) {
  CHECK(a.n.norm() == doctest::Approx(1).epsilon(1e-12));
  CHECK(b.n.norm() == doctest::Approx(1).epsilon(1e-12));
  CHECK(std::abs(a.n.dot(b.n)) < 1e-12);
  CHECK(std::abs(a.n.dot(direction)) < 1e-12);
  CHECK(std::abs(b.n.dot(direction)) < 1e-12);
}

bool add_surface(InsertionBench& bench) {
  return bench.add_rows([&] { find_surface_contact(bench.view(), bench.scratch, bench.contacts); });
}
bool add_border(InsertionBench& bench) {
  return bench.add_rows([&] { find_border_contact(bench.view(), bench.paths[0], bench.scratch, bench.contacts); });
}
bool add_path(InsertionBench& bench) {
  return bench.add_rows([&] { find_path_contacts(bench.view(), bench.paths[0], bench.scratch, bench.contacts); });
}

}  // namespace

TEST_CASE("on the surface the tip has a row along the normal and friction across it") {
  InsertionBench bench;
  bench.put_needle(on_line(kTop + 5e-4) - Vector3(2e-4, 0, 0));
  bench.move_needle(on_line(kTop + 3e-4));
  bench.locate();
  CHECK(add_surface(bench));
  REQUIRE(bench.rows.count() == 3);
  const Row& contact = bench.rows.row(0);
  CHECK(bench.contacts.found[0].kind == ContactKind::surface);
  CHECK((contact.n - Vector3::UnitZ()).norm() < kRounding);
  CHECK(contact.gap == doctest::Approx(3e-4).epsilon(1e-9));
  CHECK(bench.rows.law(0).kind == LawKind::unilateral);
  CHECK(bench.rows.law(0).limit == 0.4);  // f_p
  const Row &a = bench.rows.row(1), &b = bench.rows.row(2);
  check_across(a, b, Vector3::UnitZ());
  CHECK((a.gap * a.n + b.gap * b.n - Vector3(2e-4, 0, 0)).norm() < kRounding);
  CHECK(bench.rows.law(1).kind == LawKind::disk_first);
  CHECK(bench.rows.law(2).kind == LawKind::disk_second);
  CHECK(bench.rows.law(1).limit == 1.0);  // mu
  CHECK(bench.rows.law(1).normal_row == 0);
  CHECK(bench.rows.law(1).cohesion == 0);
}

TEST_CASE("at the end of its path the tip has a cutting row against its cutting direction") {
  Vector3 direction = -Vector3::UnitZ();
  Scene scene = one_region();
  SUBCASE("straight") {}
  SUBCASE("bevel") {  // the tip's frame points along -z and has the world's y for its own
    scene.needles[0].cutting_direction = {2, 1, 0};
    direction = Vector3(0, 1, -2).normalized();
  }
  InsertionBench bench(scene);
  bench.add_straight_path(0.020);
  bench.be_in_path(0);
  bench.put_needle(on_line(0.020));
  bench.locate();
  bench.move_needle(on_line(0.020) + 3e-4 * direction);  // beyond the end
  CHECK(add_path(bench));
  REQUIRE(bench.rows.count() == 3);
  const Row& cutting = bench.rows.row(0);
  CHECK(bench.contacts.found[0].kind == ContactKind::cut);
  CHECK((cutting.n + direction).norm() < 1e-12);
  CHECK(cutting.gap == doctest::Approx(-3e-4).epsilon(1e-9));
  CHECK(bench.rows.law(0).kind == LawKind::unilateral);
  CHECK(bench.rows.law(0).limit == 0.2);  // f_c
  check_across(bench.rows.row(1), bench.rows.row(2), direction);
  CHECK(bench.contacts.found[1].kind == ContactKind::tip);
  // k times half of the way to the last vertex, 1 mm, and 1.5 diameters of the end
  CHECK(bench.rows.law(1).compliance == doctest::Approx(1 / (50e3 * 2.5e-3)).epsilon(1e-9));
  CHECK(std::abs(bench.rows.row(1).gap) < kRounding);
  CHECK(std::abs(bench.rows.row(2).gap) < kRounding);
}

TEST_CASE("a law that can bear no force has no row") {
  Scene scene = one_region();
  scene.tissue.regions[0].interaction.cutting_force = 0;
  scene.tissue.regions[0].interaction.friction_contact = 0;
  InsertionBench bench(scene);
  bench.put_needle(on_line(kTop));
  bench.locate();
  add_surface(bench);
  CHECK(bench.rows.count() == 1);
  bench.rows.clear();
  bench.add_straight_path(0.020);
  bench.be_in_path(0);
  bench.put_needle(on_line(0.020));
  bench.locate();
  add_path(bench);
  CHECK(bench.rows.count() == 2);  // lateral ones
}

TEST_CASE("back inside its path the tip is held to the point between two vertices") {
  InsertionBench bench;
  bench.add_straight_path(0.020);
  bench.be_in_path(0);
  const Vector3 beside(2e-4, 1e-4, 0);
  bench.put_needle(on_line(0.023) + beside);  // u = 3/4
  bench.locate();
  CHECK(add_path(bench));
  REQUIRE(bench.rows.count() == 3);
  CHECK(bench.rows.row(0).gap == doctest::Approx(3e-3).epsilon(1e-9));  // to the end, where it would cut
  const Row &a = bench.rows.row(1), &b = bench.rows.row(2);
  check_across(a, b, -Vector3::UnitZ());
  CHECK(a.in_tissue.u == doctest::Approx(0.75).epsilon(1e-9));
  CHECK((a.gap * a.n + b.gap * b.n - beside).norm() < kRounding);
  CHECK(bench.rows.law(1).compliance == doctest::Approx(1 / (50e3 * 3e-3)).epsilon(1e-9));  // 1.5 mm behind
}

TEST_CASE("a tip under way to a border has its contact row beside those of its path, one that rests on it slides") {
  InsertionBench bench(two_regions(0.7));
  bench.add_straight_path(2e-4);
  bench.be_in_path(0);
  bench.put_needle(on_line(2e-4));
  SUBCASE("under way") {
    bench.locate();
    REQUIRE(bench.scratch.located.obstacle);
    CHECK_FALSE(bench.scratch.located.obstacle->under);
    add_path(bench);
    REQUIRE(bench.rows.count() == 4);
    CHECK(bench.contacts.found[1].kind == ContactKind::border);
    CHECK(bench.rows.row(1).gap == doctest::Approx(2e-4).epsilon(1e-9));
    CHECK(bench.rows.law(1).limit == 0.7);
  }
  SUBCASE("rests") {
    bench.move_needle(on_line(-1e-4));
    bench.locate();
    REQUIRE(bench.scratch.located.obstacle);
    CHECK(bench.scratch.located.obstacle->under);
    add_border(bench);
    REQUIRE(bench.rows.count() == 3);
    CHECK(bench.contacts.found[0].kind == ContactKind::border);
    CHECK((bench.rows.row(0).n - Vector3::UnitZ()).norm() < 1e-12);
    CHECK(bench.rows.row(0).gap == doctest::Approx(-1e-4).epsilon(1e-9));
    CHECK(bench.rows.law(0).limit == 0.7);
    CHECK(bench.rows.law(1).cohesion == 0.2);  // f_c
  }
}

TEST_CASE("along a border a tip cuts ahead and aside, but not on its way back") {
  // A path that comes down at 45 degrees and lies along the border for its last 4 mm.
  InsertionBench bench(two_regions(0.7));
  bench.add_path({on_line(kTop), on_line(4e-3), on_line(0), on_line(0) + Vector3(4e-3, 0, 0)}, 4e-3);
  bench.paths[0].end = bench.border_point(kLower, on_line(0) + Vector3(4e-3, 0, 0));
  bench.be_in_path(0);
  bench.state.border = kLower;
  bench.state.tip.contact.along = 0.1;
  const auto cohesion = [&](const Vector3& last_force) {
    bench.state.tip.contact.across = last_force;
    bench.put_needle(on_line(0) + Vector3(4e-3, 0, 0), Vector3(1, 0, -1).normalized());
    bench.locate();
    bench.rows.clear();
    CHECK(add_border(bench));
    REQUIRE(bench.rows.count() == 3);
    return bench.rows.law(1).cohesion;
  };
  CHECK(cohesion(Vector3::Zero()) == 0.2);
  CHECK(cohesion({-0.1, 0, 0}) == 0.2);  // against a slip ahead
  CHECK(cohesion({0, 0.1, 0}) == doctest::Approx(0.2).epsilon(1e-9));
  CHECK(cohesion({0.1, 0, 0}) == 0);
  CHECK(cohesion({0.1, 0.1, 0}) == 0);  // 45 degrees off the way back
}

TEST_CASE("a border gives way to the shaft beside it as the tissue behind it does") {
  Scene scene = two_regions(0.7);
  scene.tissue.regions[kLower].interaction.foundation_stiffness = 2e6;
  InsertionBench bench(scene);
  const MaterialPoint on_border = bench.border_point(kLower, on_line(0));
  bench.put_needle(on_line(-1e-4));
  ContactState state;
  Contact beside{.kind = ContactKind::shaft_support, .on_needle = bench.view().needle.tip(), .state = &state};
  beside.foot.point.a = on_border;
  const auto behind = [&](const MaterialPoint& p) {
    CHECK(bench.view().tissue.region(p) == kLower);
    return bench.view().tissue.lateral_compliance(p, kDiameter) / 3e-3;
  };
  CHECK(
      bench.add_rows([&] { find_support(bench.view(), beside, ContactKind::shaft_support, behind, bench.contacts); }));
  REQUIRE(bench.rows.count() == 1);
  CHECK((bench.rows.row(0).n - Vector3::UnitZ()).norm() < 1e-12);
  CHECK(bench.rows.row(0).gap == doctest::Approx(-1e-4).epsilon(1e-9));
  CHECK(bench.rows.row(0).compliance == doctest::Approx(1 / (2e6 * 3e-3)).epsilon(1e-9));
}

}  // namespace acus::test
