// SPDX-License-Identifier: GPL-3.0-or-later
// The rows that a contact of each hold has, and what their forces, here given, mean for its needle and its state.
#include <doctest/doctest.h>

#include "server/engine/tick/contact/contact.h"

#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {
namespace {

const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();

// Forces are the rows' first guesses: nothing is solved.
class ContactBench : public InsertionBench {
 public:
  ContactBench() { put_needle(on_line(0.020)); }

  Contact contact(ContactKind kind, ContactState& of) {
    Contact made{.kind = kind, .on_needle = view().needle.tip(), .state = &of};
    made.foot.point.a = point(on_line(0.020));
    return made;
  }
  // Adds the contact, and reads what it had in the last tick.
  void pass(Contact& contact) {
    CHECK(add_contact(contact, rows));
    if (contact.state != nullptr) contact.state->forget_forces();
    read_contact(rows, contact, forces);
  }

  std::vector<NeedleForces> forces = std::vector<NeedleForces>(2);
};

bool near(const Vector3& a, const Vector3& b) { return (a - b).norm() < 1e-15; }

}  // namespace

TEST_CASE("a contact along a normal has one row, and two more with friction; its forces are counted by its kind") {
  ContactBench bench;
  ContactState state;
  state.across = {0.1, -0.2, 0};
  const auto hold = [&](double before, bool rubs) {
    Normal normal{.n = z, .gap = 1e-3, .most = 0.5, .before = before, .compliance = 1e-4, .spring = {3e-3, 2e-3, 5e-6}};
    if (rubs)
      normal.friction = DiskFriction{.slip = {2e-4, 0, 0}, .friction = 0.3, .cohesion = 0.1, .compliance = 1e-3};
    return normal;
  };
  SUBCASE("surface, with friction") {
    Contact surface = bench.contact(ContactKind::surface, state);
    surface.hold = hold(0.4, true);
    bench.pass(surface);
    REQUIRE(bench.rows.count() == 3);
    CHECK(bench.rows.row(0).gap == doctest::Approx(1e-3 + 3e-3 - 2e-3 * 0.4).epsilon(1e-12));
    CHECK(bench.rows.row(0).compliance == doctest::Approx(2.1e-3).epsilon(1e-12));
    CHECK(bench.rows.row(0).stored == 5e-6);
    CHECK(bench.rows.law(0).kind == LawKind::unilateral);
    CHECK(bench.rows.law(0).limit == 0.5);
    const Row &a = bench.rows.row(1), &b = bench.rows.row(2);
    CHECK(near(a.gap * a.n + b.gap * b.n, Vector3(2e-4, 0, 0) - 1e-3 * Vector3(0.1, -0.2, 0)));
    CHECK(bench.rows.law(1).normal_row == 0);
    CHECK(bench.rows.law(1).cohesion == 0.1);
    CHECK(state.along == 0.4);
    CHECK(near(state.across, {0.1, -0.2, 0}));
    CHECK(near(bench.forces[0].cutting, {0.1, -0.2, 0.4}));
    CHECK(near(bench.forces[0].tip, {0.1, -0.2, 0.4}));
    CHECK_FALSE(at_most(bench.rows, surface));
  }
  SUBCASE("at its cap") {
    Contact cut = bench.contact(ContactKind::cut, state);
    cut.hold = hold(0.5, false);
    bench.pass(cut);
    CHECK(bench.rows.count() == 1);
    CHECK(at_most(bench.rows, cut));
    CHECK(near(bench.forces[0].cutting, 0.5 * z));
  }
  SUBCASE("bone beside a path, whose force is across it") {
    Contact support = bench.contact(ContactKind::shaft_support, state);
    support.hold = hold(0.4, false);
    bench.pass(support);
    CHECK(state.along == 0);
    CHECK(near(state.across, 0.4 * z));
    CHECK(near(bench.forces[0].lateral, 0.4 * z));
    CHECK(near(bench.forces[0].tip, Vector3::Zero()));
  }
  SUBCASE("a shaft on a surface") {
    Contact shaft = bench.contact(ContactKind::shaft, state);
    shaft.hold = hold(0.4, true);
    bench.pass(shaft);
    CHECK(near(bench.forces[0].lateral, 0.4 * z));
    CHECK(near(bench.forces[0].friction, {0.1, -0.2, 0}));
    CHECK(bench.forces[0].amounts == doctest::Approx(0.4 + 0.1 + 0.2).epsilon(1e-12));
  }
}

TEST_CASE("between two needles each has the other's force, and the tissue none") {
  ContactBench bench;
  ContactState state;
  Contact needles = bench.contact(ContactKind::needles, state);
  needles.foot = Foot{.needle = 1, .on_needle = needles.on_needle};
  needles.hold = Normal{.n = x, .before = 0.2};
  bench.pass(needles);
  CHECK_FALSE(bench.rows.row(0).acts_on_tissue());
  CHECK(near(bench.forces[0].needles, 0.2 * x));
  CHECK(near(bench.forces[1].needles, -0.2 * x));
  CHECK(bench.forces[0].amounts == 0);
}

TEST_CASE("across a path two rows hold, of which one is friction where the path may tear") {
  ContactBench bench;
  ContactState state;
  state.across = {0.3, -0.4, 0};
  Contact vertex = bench.contact(ContactKind::vertex, state);
  Across across{.tangent = -z, .apart = {1e-4, 2e-4, 0}, .compliance = 1e-3};
  SUBCASE("holds") {}
  SUBCASE("may tear") { across.tear = TearLimit{-x, 0.7}; }
  vertex.hold = across;
  bench.pass(vertex);
  REQUIRE(bench.rows.count() == 2);
  const Row &a = bench.rows.row(0), &b = bench.rows.row(1);
  CHECK(near(a.gap * a.n + b.gap * b.n, {1e-4, 2e-4, 0}));
  CHECK(bench.rows.law(1).kind == LawKind::bilateral);
  CHECK(bench.rows.law(1).compliance == 1e-3);
  if (across.tear) {
    CHECK(a.n == -x);
    CHECK(bench.rows.law(0).kind == LawKind::friction);
    CHECK(bench.rows.law(0).limit == 0.7);
    CHECK(a.compliance == 1e-3);
  }
  CHECK(near(state.across, {0.3, -0.4, 0}));
  CHECK(near(bench.forces[0].lateral, {0.3, -0.4, 0}));
}

TEST_CASE("along a path there is friction, and with torsional friction a cone, whose torsion is no force") {
  ContactBench bench;
  ContactState state;
  state.along = -0.01;
  state.torsion = 0.002;
  state.sliding = false;
  Along along{.tangent = -z, .slip = 2e-4, .compliance = 1e-3};
  along.friction.law.threshold = 0.01;
  SUBCASE("alone") {
    Contact vertex = bench.contact(ContactKind::vertex, state);
    vertex.hold = along;
    bench.pass(vertex);
    CHECK(bench.rows.count() == 1);
    CHECK(state.sliding);
    CHECK(state.along == -0.01);
    CHECK(near(bench.forces[0].friction, 0.01 * z));
  }
  SUBCASE("with torsion") {
    along.radius = 4e-4;
    Contact vertex = bench.contact(ContactKind::vertex, state);
    vertex.hold = along;
    CHECK(add_contact(vertex, bench.rows));
    REQUIRE(bench.rows.count() == 2);
    CHECK(bench.rows.find_cone(0));
    CHECK(bench.rows.row(1).radius == 4e-4);
  }
  SUBCASE("of a guide, which is the world's") {
    Contact guide = bench.contact(ContactKind::guide, state);
    guide.foot = {};
    guide.hold = along;
    bench.pass(guide);
    CHECK_FALSE(bench.rows.row(0).acts_on_tissue());
    CHECK(near(bench.forces[0].guides, 0.01 * z));
    CHECK(near(bench.forces[0].friction, Vector3::Zero()));
  }
}

TEST_CASE("a contact whose rows do not fit says so, and has those that did") {
  ContactBench bench;
  ContactState state;
  Rows one(1);
  Contact vertex = bench.contact(ContactKind::vertex, state);
  vertex.hold = Across{.tangent = z};
  CHECK_FALSE(add_contact(vertex, one));
  CHECK(vertex.rows == 1);
}

}  // namespace acus::test
