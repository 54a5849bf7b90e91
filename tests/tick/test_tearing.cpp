// SPDX-License-Identifier: GPL-3.0-or-later
// Paths that needles tear sideways (tick/insertion/transitions/tearing.h).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "server/engine/math/rotation.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr double kStrength = 10;  // N/m
constexpr double kDepth = 0.045;  // m

Scene rigid_needle(double strength) {
  Scene scene = block_scene(0.08);
  scene.rate = 1000;
  scene.tissue.box.size = {0.12, 0.12, 0.08};
  scene.tissue.fixed.resize(1);
  scene.tissue.fixed[0].box = Box{Vector3::Constant(-kInfinity), {kInfinity, kInfinity, -0.0399}};
  scene.tissue.regions[0].material.young_modulus = 10e3;
  scene.tissue.regions[0].interaction.pressure = 2e3;
  scene.tissue.regions[0].interaction.tear_strength = strength;
  Needle& needle = scene.needles[0];
  needle.rung = NeedleRung::rigid;
  needle.smoothing = 0;
  return scene;
}

double force_aside(const Bench& bench) { return -bench.needle().base_force.x(); }

// The sideways force that tears the whole path: t per length of shaft.
double tearing_force(const Bench& bench) { return kStrength * bench.needle().inserted_depth; }

TEST_CASE("a needle that is drawn sideways bears its path's strength times its length, there and back" *
          doctest::test_suite("gate")) {
  for (const double spacing : {2e-3, 6e-3})
    for (const int cells : {5, 9}) {
      CAPTURE(spacing);
      CAPTURE(cells);
      Scene scene = rigid_needle(kStrength);
      scene.tissue.box.cells = {cells, cells, cells};
      scene.needles[0].constraint_spacing = spacing;
      Bench bench(scene);
      bench.push(0, 0.005 + kDepth, 0.05);
      bench.wait(0.2);
      CHECK(bench.events(EventKind::tear).empty());
      bench.move(0, {0.008, 0, 0}, 0.02);
      CHECK(force_aside(bench) == doctest::Approx(tearing_force(bench)).epsilon(0.03).scale(0));
      const double before = force_aside(bench);
      bench.move(0, {0.01, 0, 0}, 0.02);  // it does not rise any more
      CHECK(force_aside(bench) == doctest::Approx(before).epsilon(0.02).scale(0));
      REQUIRE(bench.events(EventKind::tear).size() == 1);
      bench.move(0, {-0.015, 0, 0}, 0.02);
      CHECK(force_aside(bench) == doctest::Approx(-tearing_force(bench)).epsilon(0.03).scale(0));
      CHECK(bench.events(EventKind::tear).size() == 2);
      bench.push(0, -0.06, 0.05);
      CHECK(bench.events(EventKind::withdrawal).size() == 1);
      CHECK((bench.flags() & kNotFinite) == 0);
    }
}

TEST_CASE("the event of a tear tells where it begins, and the force there") {
  Bench bench(rigid_needle(kStrength));
  bench.push(0, 0.005 + kDepth, 0.05);
  bench.move(0, {0.006, 0, 0}, 0.02);
  REQUIRE(bench.events(EventKind::tear).size() == 1);
  const Event event = bench.events(EventKind::tear)[0];
  const double spacing = bench.simulation().scene().needles[0].constraint_spacing;
  CHECK(event.force > 0.5 * kStrength * spacing);
  CHECK(event.force < 2 * kStrength * spacing);
  CHECK(std::abs(event.position.y() - 0.002) < 1e-3);
}

TEST_CASE("a path that bears its load does not tear: the same bits as without a strength") {
  const auto forces = [](double strength) {
    Bench bench(rigid_needle(strength));
    bench.push(0, 0.005 + kDepth, 0.05);
    bench.move(0, {0.001, 0, 0}, 0.02);
    CHECK(bench.events(EventKind::tear).empty());
    return bench.needle().base_force;
  };
  CHECK(forces(60) == forces(kInfinity));
}

TEST_CASE("a torn path neither jumps nor chatters, and stays where it was torn to") {
  Scene scene = rigid_needle(kStrength);
  scene.needles[0].rung = NeedleRung::flexible;
  scene.needles[0].smoothing = 5e-3;
  Bench bench(scene);
  bench.push(0, 0.005 + kDepth, 0.05);
  double largest = 0, last = force_aside(bench);
  bench.each_tick = [&] {
    largest = std::max(largest, std::abs(force_aside(bench) - last));
    last = force_aside(bench);
  };
  bench.move(0, {0.03, 0, 0}, 0.03);
  CHECK(largest < 0.01);
  bench.wait(0.5);
  const std::size_t tears = bench.events(EventKind::tear).size();
  const double resting = force_aside(bench);
  bench.wait(0.5);
  CHECK(force_aside(bench) == doctest::Approx(resting).epsilon(1e-3).scale(0));
  CHECK(bench.events(EventKind::tear).size() == tears);
}

TEST_CASE("a tear does not go through bone") {
  Scene scene = rigid_needle(2);
  Region bone = scene.tissue.regions[0];
  bone.name = "bone";
  bone.box = Box{{0.008, -kInfinity, -kInfinity}, Vector3::Constant(kInfinity)};
  bone.material.young_modulus = 1e9;
  bone.interaction.puncture_force = kInfinity;
  scene.tissue.regions.push_back(bone);
  scene.tissue.box.cells = {15, 5, 5};
  scene.needles[0].base.position.x() = 0.001;
  Bench bench(scene);
  bench.push(0, 0.005 + 0.03, 0.05);
  bench.move(0, {0.004, 0, 0}, 0.02);
  const double soft = force_aside(bench);
  const std::size_t tears = bench.events(EventKind::tear).size();
  bench.move(0, {0.005, 0, 0}, 0.02);
  CHECK(force_aside(bench) > 5 * soft);
  for (const Event& event : bench.events(EventKind::tear)) CHECK(event.force < 1);
  CHECK(bench.events(EventKind::tear).size() <= tears + 1);
  for (const Path& path : bench.simulation().state().paths)
    for (int i = 0; i < path.points(); ++i) CHECK(bench.simulation().model().regions[path.point(i).tetrahedron] == 0);
}

TEST_CASE("a needle that is through takes both its mouths along") {
  Scene scene = rigid_needle(kStrength);
  scene.tissue.box = {{0.12, 0.12, 0.02}, {8, 8, 2}};
  scene.tissue.fixed[0].box = Box{Vector3::Constant(-kInfinity), {-0.05, kInfinity, kInfinity}};
  scene.tissue.fixed.emplace_back().box = Box{{0.05, -kInfinity, -kInfinity}, Vector3::Constant(kInfinity)};
  scene.needles[0] = needle_at({0.003, 0.002, 0.01}, 0.005);
  scene.needles[0].rung = NeedleRung::rigid;
  Bench bench(scene);
  bench.push(0, 0.04, 0.05);
  REQUIRE(bench.needle().phase == Phase::through);
  bench.move(0, {0, 0.012, 0}, 0.02);
  const State& state = bench.simulation().state();
  const TetrahedralMesh& mesh = bench.simulation().mesh();
  for (const Path& path : state.paths)
    for (int i = 0; i < path.points(); ++i)
      CHECK(std::abs(material_position(mesh, state.tissue.x, path.point(i)).y() - 0.014) < 1.5e-3);
  CHECK(std::abs(bench.resistance()) < 0.1);
  CHECK(bench.needle().phase == Phase::through);
}

TEST_CASE(
    "a tilted needle that is drawn along its tilt keeps its path in order, as its mouth slides along the surface") {
  for (const double way : {-0.016, 0.016}) {
    CAPTURE(way);
    Scene scene = rigid_needle(3);
    Needle& needle = scene.needles[0];
    needle.base.orientation = rotation_exp({0, -0.8, 0}) * needle.base.orientation;
    needle.base.position = Vector3(0, 0, 0.042) - needle.length * (needle.base.orientation * Vector3::UnitX());
    needle.tip = TipShape::bevel;
    needle.smoothing = 5e-3;
    Bench bench(scene);
    bench.push(0, 0.005 + kDepth, 0.05);
    double largest = 0;
    Vector3 last = bench.needle().base_force;
    bench.each_tick = [&] {
      largest = std::max(largest, (bench.needle().base_force - last).norm());
      last = bench.needle().base_force;
    };
    bench.move(0, {way, 0, 0}, 0.02);
    CHECK(largest < 0.02);
    const State& state = bench.simulation().state();
    const Vector3 axis = bench.axis();
    double before = -kInfinity;
    for (const Path& path : state.paths)
      for (int i = 0; i < path.points(); ++i) {
        const double along = axis.dot(material_position(bench.simulation().mesh(), state.tissue.x, path.point(i)));
        CHECK(along > before - 1e-4);
        if (i > 0) CHECK(along - before < 2 * path.spacing);
        before = along;
      }
  }
}

TEST_CASE("a tip that tears away from its path, drawn back, cuts anew") {
  Scene scene = rigid_needle(3);
  Bench bench(scene);
  bench.push(0, 0.005 + kDepth, 0.05);
  bench.push(0, -0.02, 0.05);
  bench.move(0, {0.01, 0, 0}, 0.02);
  bench.push(0, 0.015, 0.05);
  const Interaction& law = scene.tissue.regions[0].interaction;
  CHECK(-bench.needle().cutting_force.dot(bench.axis()) == doctest::Approx(law.cutting_force).epsilon(0.05).scale(0));
  CHECK((bench.flags() & kNotFinite) == 0);
}

TEST_CASE("a tear in a deferred field, in every rung, with relaxation" * doctest::test_suite("gate")) {
  const auto run = [](const std::function<void(Scene&)>& change) {
    Scene scene = rigid_needle(kStrength);
    scene.rate = 250;
    scene.tissue.box.cells = {4, 4, 4};
    change(scene);
    Bench bench(scene);
    bench.push(0, 0.005 + kDepth, 0.05);
    bench.move(0, {0.012, 0, 0}, 0.02);
    CHECK((bench.flags() & kNotFinite) == 0);
    CHECK(bench.events(EventKind::tear).size() >= 1);
    return force_aside(bench) / tearing_force(bench);
  };
  CHECK(run([](Scene& s) {
          s.tissue.window = 4;
          s.tissue.regions[0].material.rayleigh_stiffness = 0.02;
        }) == doctest::Approx(1).epsilon(0.08).scale(0));
  for (const TissueRung rung : {TissueRung::linear, TissueRung::refined, TissueRung::exact})
    CHECK(run([&](Scene& s) { s.tissue.rung = rung; }) == doctest::Approx(1).epsilon(0.05).scale(0));
  CHECK(run([](Scene& s) {
          s.tissue.regions[0].material.relaxation = {{1, 0.5}};
        }) == doctest::Approx(1).epsilon(0.08).scale(0));
}

}  // namespace
}  // namespace acus::test
