// SPDX-License-Identifier: GPL-3.0-or-later
// Borders between regions: what holds a tip, either way, at any speed.
#include <doctest/doctest.h>

#include <algorithm>
#include <numbers>
#include <string>

#include "server/engine/math/rotation.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr int kLower = 0, kUpper = 1;

// The block in two regions that meet at z = 0.
Scene two_layers() {
  Scene scene = block_scene();
  Region& lower = scene.tissue.regions[0];
  Region upper = lower;
  lower.name = "lower";
  lower.interaction.puncture_force = 0.7;
  upper.name = "upper";
  upper.interaction.puncture_force = 0.5;
  upper.half_space = HalfSpace{Vector3::Zero(), -Vector3::UnitZ()};
  scene.tissue.regions.push_back(upper);
  return scene;
}

// A needle that is tilted about y, its tip 5 mm before the block on the way to a point of the border.
void tilt(double degrees, Needle& needle) {
  const double angle = degrees * std::numbers::pi / 180;
  needle.base.orientation = rotation_exp({0, -angle, 0}) * needle.base.orientation;
  const Vector3 way = needle.base.orientation * Vector3::UnitX();
  needle.base.position = Vector3(0.003, 0.002, 0) - (0.03 / std::cos(angle) + needle.length + 0.005) * way;
}

// One needle from above and one from below, side by side.
Scene from_both_sides() {
  Scene scene = two_layers();
  scene.needles = {needle_at({-0.012, 0.003, 0.03}, 0.005), needle_at({0.012, -0.004, -0.03}, 0.005, false)};
  scene.needles[1].name = "from below";
  return scene;
}

// Bone below z = 0, under a thin needle that is tilted about y.
Scene bone_below(double degrees) {
  Scene scene = two_layers();
  scene.tissue.regions[kLower].name = "bone";
  scene.tissue.regions[kLower].interaction.puncture_force = kInfinity;
  scene.tissue.regions[kLower].material.young_modulus = 5e6;
  scene.tissue.fixed.emplace_back().half_space = HalfSpace{Vector3::Zero(), Vector3::UnitZ()};
  Needle& needle = scene.needles[0];
  needle.outer_diameter = 0.7e-3;
  needle.material.young_modulus = 60e9;
  const double tilt = degrees * std::numbers::pi / 180;
  needle.base.orientation = rotation_exp({0, -tilt, 0}) * needle.base.orientation;
  needle.base.position =
      Vector3(-0.02, 0.002, 0.03) - (needle.length + 0.005) * (needle.base.orientation * Vector3::UnitX());
  return scene;
}

// The bone bears a tip in a dimple, whose force at the tip's depth is the tip's at rest. In motion the spring is
// linearised about the force of the tick before: a tip that presses by half of the depth in a tick is deeper.
struct OnBone {
  const Scene& scene;
  double deepest = 0, force = 0;  // m; N, the largest

  void see(const Bench& bench) {
    deepest = std::max(deepest, -bench.needle().tip_position.z());
    force = std::max(force, bench.needle().tip_force.norm());
  }
  double force_at(double depth) const {
    const std::vector<Region>& regions = scene.tissue.regions;
    Indented sides(regions[kLower].material, regions[kLower].interaction.deep_indentation);
    sides += Indented(regions[kUpper].material, regions[kUpper].interaction.deep_indentation);
    return dimple_force(sides, scene.needles[0].outer_diameter, depth);
  }
  bool is_held() const { return force_at(deepest) <= 2 * force; }  // 1.53 at 0.28 m/s, 20 degrees
};

// Of the tip, along the needle, from its start (m).
double way_to_bone(double degrees) { return 0.005 + 0.03 / std::cos(degrees * std::numbers::pi / 180); }

// Five layers of 0.5 mm, the last region on top, over one of 3 mm; a tick of 4 ms at full speed is 1.1 mm.
constexpr double kThinCutting = 0.05;  // N

Scene thin_layers(double puncture_force) {
  Scene scene = block_scene();
  scene.rate = 250;
  scene.tissue.box.size = {0.012, 0.012, 6e-3};
  scene.tissue.box.cells = {6, 6, 12};
  scene.tissue.fixed.assign(1, Volume{});
  scene.tissue.fixed[0].half_space = HalfSpace{Vector3(0, 0, -2.9e-3), Vector3::UnitZ()};
  Region& base = scene.tissue.regions[0];
  base.material.young_modulus = 200e3;
  base.interaction.puncture_force = puncture_force;
  base.interaction.cutting_force = kThinCutting;
  for (int i = 0; i < 5; ++i) {
    Region layer = scene.tissue.regions[0];
    layer.name = "layer " + std::to_string(i + 1);
    layer.half_space = HalfSpace{Vector3(0, 0, 0.5e-3 * i), -Vector3::UnitZ()};
    scene.tissue.regions.push_back(layer);
  }
  scene.needles = {needle_at({0.0003, 0.0002, 3e-3}, 0.005)};
  return scene;
}

// Nodes stand above and below z = 0, none on it. A tilted needle bends and slides there before it crosses.
Scene stiff_border_in_steps() {
  Scene scene = two_layers();
  scene.tissue.box = {.size = {0.12, 0.12, 0.1}, .cells = {9, 9, 9}};
  scene.tissue.fixed.assign(1, Volume{});
  scene.tissue.fixed[0].half_space = HalfSpace{Vector3(0, 0, -0.0499), Vector3::UnitZ()};
  for (Region& region : scene.tissue.regions) {
    region.material = {.young_modulus = 32e3, .poisson_ratio = 0.34, .rayleigh_stiffness = 0.02};
    region.interaction = {.puncture_force = 2, .cutting_force = 0.48, .pressure = 16e3, .foundation_stiffness = {}};
    region.interaction.friction_static = 0.12;
    region.interaction.friction_dynamic = 0.1;
  }
  scene.tissue.regions[kUpper].interaction.puncture_force = 0.46;
  scene.tissue.regions[kUpper].interaction.cutting_force = 0.03;
  Needle& needle = scene.needles[0];
  needle.length = 0.14;
  needle.material.young_modulus = 200e9;
  const Vector3 axis = Vector3(0.727, -0.072, -0.683).normalized(), target(-1e-3, 5e-3, -1.5e-3);
  needle.base.orientation = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitX(), axis);
  needle.base.position = target - (0.01 + (target.z() - 0.05) / axis.z() + needle.length) * axis;
  return scene;
}

// "4 3 2": the regions of events in their order.
std::string regions_of(const std::vector<Event>& events) {
  std::string all;
  for (const Event& e : events) all += (all.empty() ? "" : " ") + std::to_string(e.region);
  return all;
}

void check_crossing(const Bench& bench, int needle, int into, double force) {
  CAPTURE(needle);
  const std::vector<Event> crossings = bench.events(EventKind::crossing, needle);
  REQUIRE(crossings.size() == 1);
  CHECK(crossings[0].region == into);
  CHECK(crossings[0].force == doctest::Approx(force).epsilon(1e-6));
}

constexpr double kFast = 0.28;  // m/s

}  // namespace

TEST_CASE("an interface has its own puncture force, the same both ways" * doctest::test_suite("gate")) {
  Scene scene = from_both_sides();
  scene.tissue.interfaces = {{.between = "upper", .and_ = "lower", .puncture_force = 0.6}};
  Bench bench(scene);
  bench.push(0, 0.05, 0.02);
  bench.push(1, 0.05, 0.02);
  check_crossing(bench, 0, kLower, 0.6);
  check_crossing(bench, 1, kUpper, 0.6);
  CHECK(bench.finite());
}

TEST_CASE("a border that is not listed has the puncture force of the region behind it" * doctest::test_suite("gate")) {
  Bench bench(from_both_sides());
  bench.push(0, 0.05, 0.02);
  bench.push(1, 0.05, 0.02);
  check_crossing(bench, 0, kLower, 0.7);
  check_crossing(bench, 1, kUpper, 0.5);
}

TEST_CASE("an interface at or below the cutting force is no obstacle, and still an event") {
  Scene scene = two_layers();
  scene.tissue.interfaces = {{.between = "upper", .and_ = "lower", .puncture_force = 0.2}};
  Bench bench(scene);
  double largest = 0;
  bench.push(0, 0.02, 0.02);
  bench.each_tick = [&] { largest = std::max(largest, bench.needle().cutting_force.norm()); };
  bench.push(0, 0.03, 0.02);
  check_crossing(bench, 0, kLower, 0.2);
  CHECK(bench.events(EventKind::contact).size() == 1);  // the surface's
  CHECK(largest < 0.2 * (1 + 1e-9));
}

TEST_CASE("bone inside is not entered at any speed, straight or tilted" * doctest::test_suite("gate")) {
  for (const double degrees : {0.0, 20.0, 40.0}) {
    CAPTURE(degrees);
    const Scene scene = bone_below(degrees);
    Bench bench(scene);
    OnBone tip{scene};
    bench.each_tick = [&] { tip.see(bench); };
    const double pushed = way_to_bone(degrees) + 0.01;
    bench.push(0, pushed, kFast);
    bench.wait(0.2);
    CHECK(bench.events(EventKind::crossing).empty());
    CHECK(bench.events(EventKind::contact).back().region == kLower);
    CHECK(tip.is_held());
    // At rest; the bone's fixed nodes lack the mesh's part of the dimple.
    CHECK(tip.force_at(-bench.needle().tip_position.z()) < bench.needle().tip_force.norm());
    bench.push(0, -pushed, kFast);
    CHECK(bench.events(EventKind::withdrawal).size() == 1);
    CHECK(tip.is_held());
    CHECK(bench.finite());
    CHECK((bench.flags() & kNotFinite) == 0);
    bench.wait(1.5);
    CHECK(bench.tissue_displacement() < 1e-9);
  }
}

int path_points(const Bench& bench) {
  Matrix3X points(3, bench.simulation().path_capacity());
  return bench.simulation().path_positions(0, points);
}

TEST_CASE("a tip that works on bone for long keeps to one path" * doctest::test_suite("gate")) {
  Bench bench(bone_below(30));
  bench.push(0, way_to_bone(30) + 0.004, 0.05);
  bench.wait(0.1);
  const int points = path_points(bench);
  for (int i = 0; i < 50; ++i) {  // a hand that presses and gives way
    bench.push(0, -0.002, 0.05);
    bench.push(0, 0.002, 0.05);
  }
  CHECK(path_points(bench) == points);
  const std::size_t contacts = bench.events(EventKind::contact).size();
  for (int i = 0; i < 5; ++i) {  // and wipes
    bench.move(0, {0, 5e-3, 0}, 0.02);
    bench.move(0, {0, -5e-3, 0}, 0.02);
  }
  CHECK(path_points(bench) == points);
  CHECK(bench.events(EventKind::contact).size() <= contacts + 2);
  CHECK(bench.events(EventKind::crossing).empty());
  CHECK(bench.finite());
}

TEST_CASE("bone inside is not entered by trying again, nor from the side" * doctest::test_suite("gate")) {
  for (const double degrees : {0.0, 30.0}) {
    CAPTURE(degrees);
    const Scene scene = bone_below(degrees);
    Bench bench(scene);
    OnBone tip{scene};
    bench.each_tick = [&] { tip.see(bench); };
    const double pushed = way_to_bone(degrees) + 0.003;
    bench.push(0, pushed, 0.05);
    for (int repeat = 0; repeat < 3; ++repeat) {
      bench.push(0, -0.01, 0.05);
      bench.push(0, 0.01, 0.05);
    }
    CHECK(bench.events(EventKind::release).size() == 3);
    for (const Vector3& aside : {Vector3(8e-3, 0, 0), Vector3(0, 5e-3, 0), Vector3(-1e-2, 0, 0)})
      bench.move(0, aside, 0.02);
    CHECK(bench.events(EventKind::crossing).empty());
    CHECK(tip.is_held());
    bench.push(0, -pushed, 0.05);
    bench.wait(1);
    CHECK(bench.finite());
    CHECK(bench.tissue_displacement() < 1e-9);
  }
}

TEST_CASE(
    "a tip comes to a border without a step of force, straight or tilted, blunt or sharp, in tissue that relaxes, too" *
    doctest::test_suite("gate")) {
  for (const double degrees : {0.0, 20.0, 40.0}) {
    for (const TipShape shape : {TipShape::blunt, TipShape::trocar}) {
      for (const bool relaxes : {false, true}) {
        CAPTURE(degrees);
        CAPTURE(static_cast<int>(shape));
        CAPTURE(relaxes);
        Scene scene = two_layers();
        for (Region& region : scene.tissue.regions) {
          region.material.rayleigh_stiffness = 0.02;
          if (relaxes) region.material.relaxation = {{.ratio = 1, .time = 0.1}};
        }
        scene.needles[0].tip = shape;
        tilt(degrees, scene.needles[0]);
        Bench bench(scene);
        Vector3 before = Vector3::Zero();
        double step = 0, pressed = 0;
        bench.each_tick = [&] {
          const Vector3 force = bench.needle().base_force;
          const bool on_border = bench.events(EventKind::contact).size() > 1;
          if (on_border && bench.events(EventKind::crossing).empty()) {
            step = std::max(step, (force - before).norm());
            pressed = std::max(pressed, bench.needle().cutting_force.norm());
          }
          before = force;
        };
        bench.push(0, 0.013 + 0.03 / std::cos(degrees * std::numbers::pi / 180), 0.02);
        CHECK(bench.events(EventKind::contact).size() == 2);
        CHECK(pressed > 0.4);
        CHECK(step < 0.03);
        CHECK(bench.finite());
      }
    }
  }
}

TEST_CASE("a tip that slid along a border that the mesh has in steps goes straight on as it crosses" *
          doctest::test_suite("gate")) {
  Bench bench(stiff_border_in_steps());
  Vector3 before = Vector3::Zero();
  double step = 0, pressed = 0, behind = 0;
  int ticks_behind = 0;
  bench.each_tick = [&] {
    const Vector3 force = bench.needle().base_force;
    if (bench.events(EventKind::crossing).empty()) {
      pressed = force.norm();
    } else if (++ticks_behind > 2) {
      behind = std::max(behind, force.norm());
      step = std::max(step, (force - before).norm());
    }
    before = force;
  };
  bench.push(0, 0.105, 0.0144);
  CHECK(bench.events(EventKind::crossing).size() == 1);
  CHECK(pressed > 3);
  CHECK(behind < pressed / 2);
  CHECK(step < 0.02);
  CHECK(bench.finite());
}

TEST_CASE("a border gives way as far on a coarse mesh as on a fine one" * doctest::test_suite("gate")) {
  const auto tip_at_crossing = [](int cells) {
    Scene scene = two_layers();
    scene.tissue.box.cells = {cells, cells, cells};
    Bench bench(scene);
    bench.push(0, 0.045, 0.02);
    const std::vector<Event> crossings = bench.events(EventKind::crossing);
    REQUIRE(crossings.size() == 1);
    return crossings[0].position.z();
  };
  const double coarse = tip_at_crossing(4), fine = tip_at_crossing(10);  // cells of 15 and 6 mm
  MESSAGE("tip ", -1e3 * coarse, " and ", -1e3 * fine, " mm behind the border as it gives way");
  CHECK(fine < -1e-3);
  CHECK(coarse == doctest::Approx(fine).epsilon(0.05).scale(0));
}

TEST_CASE("a tip that lets go of a border and comes back presses on it as before" * doctest::test_suite("gate")) {
  Scene scene = two_layers();
  for (Region& region : scene.tissue.regions) region.material.rayleigh_stiffness = 0.02;
  Bench bench(scene);
  bench.push(0, 0.0375, 0.02);
  bench.wait(0.5);
  const double pressed = bench.needle().cutting_force.norm();
  CHECK(pressed > 0.3);
  for (int i = 0; i < 3; ++i) {
    bench.push(0, -0.006, 0.02);
    CHECK(bench.events(EventKind::release).size() == static_cast<std::size_t>(i) + 1);
    CHECK(bench.needle().cutting_force.norm() < 1e-9);
    bench.push(0, 0.006, 0.02);
    bench.wait(0.5);
    CHECK(bench.events(EventKind::contact).size() == static_cast<std::size_t>(i) + 3);
    CHECK(bench.needle().cutting_force.norm() == doctest::Approx(pressed).epsilon(0.05));
  }
  CHECK(bench.events(EventKind::crossing).empty());
  CHECK(bench.finite());
}

TEST_CASE("thin layers that a tick takes the tip through each give their event, in order") {
  Bench bench(thin_layers(kThinCutting));
  std::size_t most = 0;
  bench.each_tick = [&] { most = std::max(most, bench.simulation().report().events.size()); };
  bench.push(0, 0.01, kFast);
  bench.wait(0.1);
  CHECK(regions_of(bench.events(EventKind::crossing)) == "4 3 2 1 0");
  CHECK(most >= 2);
  CHECK(bench.finite());
}

TEST_CASE("thin layers that each hold the tip give contact and crossing, in order") {
  constexpr double kPuncture = 2 * kThinCutting;
  Bench bench(thin_layers(kPuncture));
  bench.push(0, 0.01, kFast);
  bench.wait(0.1);
  CHECK(regions_of(bench.events(EventKind::crossing)) == "4 3 2 1 0");
  CHECK(regions_of(bench.events(EventKind::contact)) == "5 4 3 2 1 0");
  for (const Event& e : bench.events(EventKind::crossing)) CHECK(e.force == doctest::Approx(kPuncture).epsilon(1e-6));
  CHECK(bench.finite());
}

}  // namespace acus::test
