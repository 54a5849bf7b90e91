// SPDX-License-Identifier: GPL-3.0-or-later
// Tissue that relaxes, as a needle feels it: what is strained at once and held falls as its Prony series, the mesh's
// part and that of the springs finer than the mesh alike.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "server/engine/state/bytes/state_bytes.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

constexpr Relaxation kFast{.ratio = 0.6, .time = 0.2}, kSlow{.ratio = 0.4, .time = 1};

double prony(double t) { return 1 + kFast.ratio * std::exp(-t / kFast.time) + kSlow.ratio * std::exp(-t / kSlow.time); }

Scene relaxing_scene(bool relaxes = true) {
  Scene scene = block_scene(0.06);
  Material& material = scene.tissue.regions[0].material;
  material.rayleigh_stiffness = 2e-3;  // ends waves
  if (relaxes) material.relaxation = {kFast, kSlow};
  scene.needles[0].rung = NeedleRung::rigid;
  return scene;
}

// Of the tissue on the needle (N).
Vector3 force(const Bench& bench) {
  const NeedleReport& needle = bench.needle();
  return needle.cutting_force + needle.friction_force + needle.lateral_force;
}

// The change of the tissue's force along a move (m) of a few ticks, of the needle or its guide, over what tissue at
// rest answers to it, at times (s) after the move.
std::vector<double> answers(const std::function<void(Bench&)>& prepare, const Scene& scene, const Scene& at_rest,
                            const Vector3& move, const std::vector<double>& times, int body = 0) {
  const auto moved = [&](Bench& bench) {
    prepare(bench);
    const Vector3 before = force(bench);
    bench.move(body, move, 0.1);
    return before;
  };
  Bench still(at_rest);
  const Vector3 rest = moved(still);
  still.wait(1);
  const double expected = (force(still) - rest).dot(move);
  Bench bench(scene);
  const Vector3 before = moved(bench);
  std::vector<double> found;
  double t = 0;
  for (const double time : times) {
    bench.wait(time - t);
    t = time;
    found.push_back((force(bench) - before).dot(move) / expected);
  }
  CHECK(bench.flags() == 0);
  return found;
}

void check_prony(const std::vector<double>& found, const std::vector<double>& times, double within) {
  for (std::size_t i = 0; i < times.size(); ++i) {
    CAPTURE(times[i]);
    MESSAGE("after ", times[i], " s: ", found[i], ", Prony series ", prony(times[i]));
    CHECK(found[i] == doctest::Approx(prony(times[i])).epsilon(within).scale(0));
  }
}

const std::vector<double> kTimes{0.1, 0.2, 0.5, 2};

}  // namespace

TEST_CASE("a tip that presses on the skin and holds feels the Prony series" * doctest::test_suite("gate")) {
  const auto prepare = [](Bench& bench) { bench.push(0, 0.005, 0.05); };
  Scene scene = relaxing_scene(), at_rest = relaxing_scene(false);
  const Vector3 down(0, 0, -1e-4);
  check_prony(answers(prepare, scene, at_rest, down, kTimes), kTimes, 3e-3);
}

TEST_CASE("a needle inside that is moved aside, or drawn while friction holds it, and held feels the Prony series" *
          doctest::test_suite("gate")) {
  const auto prepare = [](Bench& bench) {
    bench.push(0, 0.035, 0.02);
    bench.wait(6);  // until what it has strained on its way has relaxed
  };
  check_prony(answers(prepare, relaxing_scene(), relaxing_scene(false), Vector3(2e-4, 0, 0), kTimes), kTimes, 3e-3);
  check_prony(answers(prepare, relaxing_scene(), relaxing_scene(false), Vector3(0, 0, 1e-4), kTimes), kTimes, 0.01);
}

// Two halves that meet at z = 0.
Scene with_border(bool relaxes, double puncture_force) {
  Scene scene = relaxing_scene(relaxes);
  Region& lower = scene.tissue.regions[0];
  Region upper = lower;
  lower.name = "lower";
  lower.interaction.puncture_force = puncture_force;
  upper.name = "upper";
  upper.half_space = HalfSpace{Vector3::Zero(), -Vector3::UnitZ()};
  scene.tissue.regions.push_back(upper);
  return scene;
}

TEST_CASE("a tip on a border that is pressed onto it, or moved along it, and held feels the Prony series" *
          doctest::test_suite("gate")) {
  const auto prepare = [](Bench& bench) {
    bench.push(0, 0.037, 0.02);
    bench.wait(6);
    REQUIRE(bench.simulation().state().insertions[0].border >= 0);
  };
  const Scene scene = with_border(true, 3), at_rest = with_border(false, 3);
  SUBCASE("onto") { check_prony(answers(prepare, scene, at_rest, {0, 0, -1e-4}, kTimes), kTimes, 0.02); }
  SUBCASE("along") { check_prony(answers(prepare, scene, at_rest, {1e-4, 0, 0}, kTimes), kTimes, 0.02); }
}

TEST_CASE("a shaft that lies on the skin, is pressed onto it and held feels the Prony series" *
          doctest::test_suite("gate")) {
  const auto lying = [](bool relaxes) {
    Scene scene = relaxing_scene(relaxes);
    scene.tissue.box = {Vector3(0.12, 0.12, 0.06), {8, 8, 4}};
    scene.tissue.fixed = {Volume{}};
    scene.tissue.fixed[0].half_space = HalfSpace{Vector3(0, 0, -0.0299), Vector3::UnitZ()};
    scene.tissue.regions[0].interaction.friction_contact = 0;
    scene.tissue.regions[0].interaction.puncture_force = 3;
    Needle& needle = scene.needles[0];
    needle.length = 0.06;
    needle.base = {Vector3(-0.03, 0.0021, 0.031), Quaternion::Identity()};
    return scene;
  };
  const auto prepare = [](Bench& bench) {
    bench.move(0, {0, 0, -2e-3}, 0.02);
    bench.wait(6);
  };
  check_prony(answers(prepare, lying(true), lying(false), {0, 0, -1e-4}, kTimes), kTimes, 0.02);
}

TEST_CASE("a flexible needle that a guide moves aside in the tissue and holds feels the Prony series" *
          doctest::test_suite("gate")) {
  const auto guided = [](bool relaxes) {
    Scene scene = relaxing_scene(relaxes);
    Needle& needle = scene.needles[0];
    needle.rung = NeedleRung::flexible;
    needle.outer_diameter = 2e-3;
    needle.material.young_modulus = 1e13;  // a needle that bends is a spring in series, which does not relax
    Guide guide;
    guide.pose = {needle.base * Vector3(0.09, 0, 0), needle.base.orientation};
    scene.guides = {guide};
    return scene;
  };
  const auto prepare = [](Bench& bench) {
    bench.push(0, 0.035, 0.02);
    bench.wait(6);
  };
  check_prony(answers(prepare, guided(true), guided(false), {2e-4, 0, 0}, kTimes, 1), kTimes, 0.02);
}

TEST_CASE("the skin that a needle has carried along creeps on while friction holds it" * doctest::test_suite("gate")) {
  Bench bench(relaxing_scene());
  bench.push(0, 0.035, 0.05);
  const double before = bench.needle().inserted_depth;
  double least = 0, last = before;
  bench.each_tick = [&] {
    least = std::min(least, last - bench.needle().inserted_depth);
    last = bench.needle().inserted_depth;
  };
  bench.wait(5);
  MESSAGE("depth: ", 1e3 * before, " mm, then ", 1e3 * last, " mm");
  CHECK(last < before);
  CHECK(least > -1e-9);
}

TEST_CASE("friction of a needle that has hardly entered acts against it in every tick" * doctest::test_suite("gate")) {
  Scene scene = relaxing_scene();
  scene.tissue.regions[0].material.relaxation[0].ratio = 3;
  scene.tissue.regions[0].interaction.puncture_force = 0.02;
  scene.tissue.regions[0].interaction.cutting_force = 0.01;
  Bench bench(scene);
  int inside = 0;
  bench.each_tick = [&] {
    if (bench.needle().phase != Phase::inside) return;
    ++inside;
    CHECK(bench.needle().friction_force.dot(bench.axis()) <= 1e-9);
  };
  bench.push(0, 0.0055, 2e-3);
  CHECK(inside > 50);
}

// Largest step of the base's force in a tick, but at events and in the two ticks after them.
double largest_step(bool relaxes) {
  Scene scene = relaxing_scene(relaxes);
  scene.needles[0].rung = NeedleRung::flexible;
  scene.needles[0].cutting_direction = {1, 0.05, 0};
  Bench bench(scene);
  double before = 0, step = 0;
  int since_event = 0;
  bench.each_tick = [&] {
    since_event = bench.simulation().report().events.empty() ? since_event + 1 : 0;
    if (since_event > 2) step = std::max(step, std::abs(bench.resistance() - before));
    before = bench.resistance();
  };
  bench.push(0, 0.06, 0.01);
  bench.wait(1);
  bench.push(0, 0.015, 0.01);  // out below
  bench.wait(1);
  bench.push(0, -0.08, 0.01);
  bench.push(0, 0.03, 0.01);  // by the old mouth
  CHECK(bench.events(EventKind::exit).size() == 1);
  CHECK(bench.events(EventKind::withdrawal).size() == 1);
  CHECK(bench.events(EventKind::reentry).size() == 2);
  CHECK(bench.flags() == 0);
  return step;
}

TEST_CASE("a bevel that cuts, leaves, comes back and enters again meets steps as in tissue at rest, times its stiffness" *
          doctest::test_suite("gate")) {
  const double at_rest = largest_step(false), relaxing = largest_step(true);
  MESSAGE("largest step of the force in a tick: ", relaxing, " N, in tissue at rest ", at_rest, " N");
  CHECK(relaxing < prony(0) * at_rest);
}

TEST_CASE("in time a deep dimple is that of tissue at rest, and its force falls all the while" *
          doctest::test_suite("gate")) {
  Scene scene = relaxing_scene(), at_rest = relaxing_scene(false);
  for (Scene* each : {&scene, &at_rest}) each->tissue.regions[0].interaction.puncture_force = 3;
  Bench bench(scene), still(at_rest);
  for (Bench* each : {&bench, &still}) each->push(0, 0.009, 0.05);
  double before = bench.resistance(), least_fall = kInfinity;
  CHECK(before > 1.3 * still.resistance());
  bench.wait(0.1);
  before = bench.resistance();
  bench.each_tick = [&] {
    least_fall = std::min(least_fall, before - bench.resistance());
    before = bench.resistance();
  };
  bench.wait(8);
  still.wait(1);
  CHECK(least_fall > -1e-6);
  CHECK(bench.resistance() == doctest::Approx(still.resistance()).epsilon(2e-3).scale(0));
}

TEST_CASE("a fast tip punctures sooner in tissue that relaxes: it is stiffer, the force is the same" *
          doctest::test_suite("gate")) {
  const auto depth_at_puncture = [](double speed) {
    Bench bench(relaxing_scene());
    double depth = 0;
    bench.each_tick = [&] {
      if (bench.events(EventKind::puncture).empty()) depth = 0.03 - bench.needle().tip_position.z();
    };
    bench.push(0, 0.025, speed);
    REQUIRE(bench.events(EventKind::puncture).size() == 1);
    CHECK(bench.events(EventKind::puncture)[0].force == doctest::Approx(0.4).epsilon(0.01));
    return depth;
  };
  const double slow = depth_at_puncture(1e-3), fast = depth_at_puncture(0.1);
  MESSAGE("depth at the puncture: ", 1e3 * slow, " mm at 1 mm/s, ", 1e3 * fast, " mm at 100 mm/s");
  CHECK(fast < 0.82 * slow);
}

TEST_CASE("the bytes of a state hold what tissue and springs remember" * doctest::test_suite("gate")) {
  Scene scene = relaxing_scene();
  Simulation simulation(scene), other(scene);
  Pose pose = scene.needles[0].base;
  const auto go = [&](Simulation& each, int ticks, double step, Pose from) {
    for (int i = 0; i < ticks; ++i) {
      from.position += step * (from.orientation * Vector3::UnitX());
      REQUIRE(each.command(0, {.seq = 1, .pose = from, .spin = 0}));
      each.step();
    }
    return from;
  };
  pose = go(simulation, 500, 4e-5, pose);
  const std::vector<std::byte> bytes = to_bytes(simulation.state());
  const Insertion& insertion = simulation.state().insertions[0];
  REQUIRE(insertion.vertices[1].contact.creep.along.norm() > 0);
  REQUIRE(insertion.vertices[1].contact.creep.across.norm() > 0);
  REQUIRE(insertion.tip.contact.creep.across.norm() > 0);
  State middle = other.state();
  from_bytes(bytes, middle);
  go(simulation, 300, -1e-5, pose);
  other.restore(middle);
  go(other, 300, -1e-5, pose);
  CHECK(hash(simulation.state()) == hash(other.state()));
}

}  // namespace acus::test
