// SPDX-License-Identifier: GPL-3.0-or-later
// A law that cannot bear a force has no rows, and what is left behaves as in the limit of a tiny force.
#include <doctest/doctest.h>

#include <functional>

#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kTiny = 1e-9;  // of a coefficient: no force to speak of, but its rows are there

Interaction& interaction(Scene& scene, std::size_t region = 0) { return scene.tissue.regions[region].interaction; }

// Its needle 20 mm deep in the block, at rest.
struct Insertion20 {
  explicit Insertion20(const Scene& scene) : bench(scene) {
    bench.push(0, 0.025, 0.05);
    bench.wait(0.1);
    CHECK(bench.flags() == 0);
    CHECK(bench.needle().phase == Phase::inside);
  }
  int rows() const { return bench.simulation().report().rows; }

  Bench bench;
};

// Runs the scene with a coefficient at zero and next to zero: the same forces, and so many rows less.
struct Comparison {
  using Set = std::function<void(Scene&, double)>;

  Comparison(const Scene& scene, const Set& set) : without(with_value(scene, set, 0)), with(with_value(scene, set, kTiny)) {
    const NeedleReport& a = without.bench.needle();
    const NeedleReport& b = with.bench.needle();
    CHECK(a.inserted_depth == doctest::Approx(b.inserted_depth).epsilon(1e-6));
    CHECK((a.base_force - b.base_force).norm() < 3e-9);
    CHECK((a.base_torque - b.base_torque).norm() < 1e-9);
  }
  int rows_less() const { return with.rows() - without.rows(); }

  Insertion20 without, with;

 private:
  static Scene with_value(Scene scene, const Set& set, double value) {
    set(scene, value);
    return scene;
  }
};

// Two rows across the path per vertex, the tip's two, and its cutting row.
int vertices_without_friction(int rows) { return (rows - 3) / 2; }

void set_friction(Interaction& law, double mu) { law.friction_static = law.friction_dynamic = mu; }

}  // namespace

TEST_CASE("a shaft without friction coefficients has no friction rows") {
  const Comparison friction(block_scene(), [](Scene& scene, double mu) { set_friction(interaction(scene), mu); });
  CHECK(friction.rows_less() == vertices_without_friction(friction.without.rows()));
  CHECK(friction.rows_less() >= 5);
  CHECK(friction.without.bench.needle().friction_force.isZero(0));
}

TEST_CASE("neither has one on which the tissue does not press") {
  const Comparison pressure(block_scene(), [](Scene& scene, double p) { interaction(scene).pressure = p; });
  CHECK(pressure.rows_less() == vertices_without_friction(pressure.without.rows()));
}

TEST_CASE("viscous friction alone keeps the rows") {
  Scene scene = block_scene();
  set_friction(interaction(scene), 0);
  const Comparison viscosity(scene, [](Scene& s, double b) { interaction(s).friction_viscous = b; });
  CHECK(viscosity.rows_less() == vertices_without_friction(viscosity.without.rows()));
}

TEST_CASE("torsional friction is one row per vertex, where there is friction") {
  const auto twist = [](Scene& scene, double share) { scene.needles[0].torsional_friction = share; };
  const Comparison torsion(block_scene(), twist);
  CHECK(torsion.rows_less() == (torsion.without.rows() - 3) / 3);
  Scene smooth = block_scene();
  set_friction(interaction(smooth), 0);
  CHECK(Comparison(smooth, twist).rows_less() == 0);
}

TEST_CASE("friction is left out where a region has none") {
  Scene scene = block_scene();
  scene.tissue.regions.push_back(scene.tissue.regions[0]);
  scene.tissue.regions[1].name = "upper";
  scene.tissue.regions[1].box = Box{{-kInfinity, -kInfinity, 0.02}, Vector3::Constant(kInfinity)};
  const Comparison upper(scene, [](Scene& s, double mu) { set_friction(interaction(s, 1), mu); });
  const Comparison both(scene, [](Scene& s, double mu) {
    set_friction(interaction(s, 0), mu);
    set_friction(interaction(s, 1), mu);
  });
  CHECK(upper.rows_less() > 0);
  CHECK(upper.rows_less() < both.rows_less());
}

TEST_CASE("tissue that cuts without force has no cutting row, and the path grows with the tip") {
  Scene scene = block_scene();
  scene.needles[0].smoothing = 5e-3;  // a base that stops at once lets the tip spring back from the end of its path
  const Comparison cutting(scene, [](Scene& s, double f_c) { interaction(s).cutting_force = f_c; });
  CHECK(cutting.rows_less() == 1);
  const Simulation& simulation = cutting.without.bench.simulation();
  Matrix3X points(3, simulation.path_capacity());
  const int count = simulation.path_positions(0, points);
  REQUIRE(count > 4);
  const Vector3 apart = points.col(count - 1) - cutting.without.bench.needle().tip_position;
  CHECK(std::abs(apart.dot(cutting.without.bench.axis())) < 5e-9);
  CHECK(apart.norm() < 5e-5);  // the tissue gives way beside it
}

TEST_CASE("a smooth surface has no rows of contact friction") {
  const auto rows_in_contact = [](double mu) {
    Scene scene = block_scene();
    interaction(scene).friction_contact = mu;
    interaction(scene).puncture_force = kInfinity;
    Bench bench(scene);
    bench.push(0, 0.006, 0.02);
    CHECK(bench.needle().phase == Phase::contact);
    return bench.simulation().report().rows;
  };
  CHECK(rows_in_contact(0.5) == 3);
  CHECK(rows_in_contact(0) == 1);
}

TEST_CASE("a guide without friction has no friction row") {
  const auto rows = [](double mu) {
    Scene scene = block_scene();
    Guide guide;
    guide.pose = {scene.needles[0].base * Vector3(0.06, 0, 0), scene.needles[0].base.orientation};
    guide.friction = mu;
    scene.guides = {guide};
    Bench bench(scene);
    bench.move(1, {1e-3, 0, 0}, 0.01);
    return bench.simulation().report().rows;
  };
  CHECK(rows(0.2) == 3);
  CHECK(rows(0) == 2);
}

}  // namespace acus::test
