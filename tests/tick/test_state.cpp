// SPDX-License-Identifier: GPL-3.0-or-later
// The state is a value, and complete: whoever has it can go on with the run, and a tick that is refused leaves it alone.
#include <doctest/doctest.h>

#include <limits>
#include <map>
#include <span>

#include "server/engine/math/random.h"
#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"
#include "server/engine/tick/step.h"
#include "tests/study/bench/trajectory_driver.h"
#include "tests/support/scenes.h"

namespace acus::test {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Scene scene_of(const char* name, TissueRung rung) {
  Scene scene = read_scene(scene_file(name));
  scene.tissue.rung = rung;
  return scene;
}

// Four times as fast, so that much has happened soon.
client::Trajectory motion_of(const char* trajectory) { return fast_trajectory(trajectory, 4); }

// Runs half of the motion, or `before` ticks, gives the state to a fresh simulation, and holds that both go on alike.
void check_goes_on(const SceneWithTrajectory& experiment, TissueRung rung, std::uint64_t before, int after) {
  const Scene scene = scene_of(experiment.scene, rung);
  Simulation first(scene);
  TrajectoryDriver drive_first(first, motion_of(experiment.trajectory));
  const auto tick = [](Simulation& simulation, TrajectoryDriver& driver) {
    driver.command();
    simulation.step();
  };
  const std::uint64_t half = std::min(drive_first.ticks() / 2, before);
  for (std::uint64_t i = 0; i < half; ++i) tick(first, drive_first);

  Simulation second(scene);
  TrajectoryDriver drive_second(second, motion_of(experiment.trajectory));
  second.restore(read_snapshot(second.model(), make_snapshot(first.model().fingerprint, first.state())));
  REQUIRE(hash(second.state()) == hash(first.state()));
  for (int i = 0; i < after; ++i) {
    tick(first, drive_first);
    tick(second, drive_second);
    if (hash(first.state()) == hash(second.state())) continue;
    FAIL_CHECK("the states differ ", i + 1, " ticks after the copy");
    return;
  }
}

void check_all(std::span<const SceneWithTrajectory> scenes, TissueRung rung, std::uint64_t before, int after) {
  for (const SceneWithTrajectory& experiment : scenes) {
    if (!experiment.runs_on(rung)) continue;
    CAPTURE(experiment.scene);
    check_goes_on(experiment, rung, before, after);
  }
}

// Makes a run once, and goes on from snapshots of it.
void check_branches(const SceneWithTrajectory& experiment, TissueRung rung) {
  constexpr int kBranches = 20;
  constexpr std::uint64_t kTicks = 2000;
  Simulation simulation(scene_of(experiment.scene, rung));
  TrajectoryDriver driver(simulation, motion_of(experiment.trajectory));
  Random random(1);
  std::map<std::uint64_t, std::vector<std::byte>> snapshots;
  while (snapshots.size() < kBranches) snapshots[static_cast<std::uint64_t>(random.index(static_cast<int>(driver.ticks())))];
  std::vector<std::uint64_t> hashes;
  const auto tick = [&] {
    driver.command();
    simulation.step();
    return hash(simulation.state());
  };
  while (hashes.size() < snapshots.rbegin()->first + kTicks) {
    if (const auto here = snapshots.find(hashes.size()); here != snapshots.end())
      here->second = make_snapshot(simulation.model().fingerprint, simulation.state());
    hashes.push_back(tick());
  }
  for (const auto& [begin, snapshot] : snapshots) {
    simulation.restore(read_snapshot(simulation.model(), snapshot));
    std::uint64_t i = begin;
    while (i < begin + kTicks && tick() == hashes[i]) ++i;
    CAPTURE(begin);
    CHECK(i == begin + kTicks);
  }
}

// A bevel needle with torsional friction in a guide with friction, in the middle of an insertion.
class Poisoned {
 public:
  Poisoned() : simulation_(scene_of("deep_brain", TissueRung::warped)), driver_(simulation_, motion_of("deep_brain")) {
    for (int i = 0; i < 600; ++i) {
      driver_.command();
      simulation_.step();
    }
  }

  const Model& model() const { return simulation_.model(); }
  const State& state() const { return simulation_.state(); }
  Commands no_commands() const { return Commands(model().scene.needles.size() + model().scene.guides.size()); }
  Command go_on() const {
    Pose pose = state().bases[0].target;
    pose.position += 1e-4 * (pose.orientation * Vector3::UnitX());
    return {.seq = 700, .pose = pose, .spin = 0.3};
  }

 private:
  Simulation simulation_;
  TrajectoryDriver driver_;
};

TickReport make_report(const Model& model) {
  TickReport report;
  report.needles.resize(model.needles.size());
  return report;
}

}  // namespace

TEST_CASE("a copied state goes on as the original: rung linear, first half of the scenes") {
  check_all(std::span(kScenes).first(7), TissueRung::linear, 1000, 1000);
}
TEST_CASE("a copied state goes on as the original: rung linear, second half of the scenes" *
          doctest::test_suite("full")) {
  check_all(std::span(kScenes).subspan(7), TissueRung::linear, 1000, 1000);
}
TEST_CASE("a copied state goes on as the original: rung warped" * doctest::test_suite("full")) {
  check_all(kScenes, TissueRung::warped, 1000, 1000);
}
TEST_CASE("a copied state goes on as the original: rung refined, first half of the scenes" *
          doctest::test_suite("full")) {
  check_all(std::span(kScenes).first(7), TissueRung::refined, 200, 1000);
}
TEST_CASE("a copied state goes on as the original: rung refined, second half of the scenes" *
          doctest::test_suite("full")) {
  check_all(std::span(kScenes).subspan(7), TissueRung::refined, 200, 1000);
}
TEST_CASE("a copied state goes on as the original: rung exact" * doctest::test_suite("full")) {
  check_all(kScenes, TissueRung::exact, 20, 50);
}

// An hour: by hand, `test_state --no-skip --test-case="long:*"`.
TEST_CASE("long: from twenty random ticks a snapshot goes on for 2,000 ticks as the run did" * doctest::skip()) {
  for (const TissueRung rung : {TissueRung::linear, TissueRung::warped, TissueRung::refined})
    for (const SceneWithTrajectory& experiment : kScenes) {
      if (!experiment.runs_on(rung)) continue;
      CAPTURE(experiment.scene);
      check_branches(experiment, rung);
    }
}

TEST_CASE("a state is the bytes of its image, and an image of another scene is refused") {
  const Poisoned bench;
  const std::vector<std::byte> image = to_bytes(bench.state());
  State read = make_state(bench.model());
  CHECK_FALSE(identical(read, bench.state()));
  from_bytes(image, read);
  CHECK(identical(read, bench.state()));
  CHECK(hash(read) == hash(bench.state()));
  CHECK(read.paths[0].vertices.capacity() == bench.state().paths[0].vertices.capacity());

  State other = read;
  other.tissue.x(0, 0) = std::nextafter(other.tissue.x(0, 0), 1.0);
  CHECK(hash(other) != hash(read));

  const State before = read;
  for (const std::size_t length : {std::size_t{0}, std::size_t{1}, image.size() / 2, image.size() - 1})
    CHECK_THROWS(from_bytes(std::span(image).first(length), read));
  std::vector<std::byte> longer = image;
  longer.push_back({});
  CHECK_THROWS(from_bytes(longer, read));
  const Simulation small(scene_of("biopsy", TissueRung::warped));
  CHECK_THROWS(from_bytes(to_bytes(small.state()), read));
  CHECK(identical(read, before));
}

TEST_CASE("a tick that is poisoned never happened") {
  const Poisoned bench;
  const Model& model = bench.model();
  TickReport report = make_report(model);

  // What the next tick is, had nothing happened.
  State expected = bench.state();
  Commands commands = bench.no_commands();
  commands[0] = bench.go_on();
  Scratch fresh(model);
  step(model, commands, expected, fresh, report);
  CHECK((report.flags & kNotFinite) == 0);
  REQUIRE(expected.tick == bench.state().tick + 1);

  State state = bench.state();
  Scratch scratch(model);
  const auto check = [&](const char* what, int body, const Command& poison) {
    CAPTURE(what);
    Commands poisoned = bench.no_commands();
    poisoned[static_cast<std::size_t>(body)] = poison;
    step(model, poisoned, state, scratch, report);
    CHECK((report.flags & kNotFinite) != 0);
    CHECK(report.tick == bench.state().tick);
    CHECK(identical(state, bench.state()));
    for (const NeedleReport& n : report.needles) CHECK(n.base.position.allFinite());
    State next = state;
    step(model, commands, next, scratch, report);
    CHECK((report.flags & kNotFinite) == 0);
    CHECK(identical(next, expected));
  };
  const Pose pose = bench.state().bases[0].target;
  const int bodies = model.needle_count() + model.guide_count();
  for (int body = 0; body < bodies; ++body) {
    CAPTURE(body);
    for (const double bad : {kNan, kInfinity, -kInfinity}) {
      for (int axis = 0; axis < 3; ++axis) {
        Command poison{.seq = 1, .pose = pose, .spin = {}};
        poison.pose->position[axis] = bad;
        check("position", body, poison);
      }
      Command turned{.seq = 1, .pose = pose, .spin = {}};
      turned.pose->orientation.coeffs()[2] = bad;
      check("orientation", body, turned);
    }
  }
  check("spin", 0, {.seq = 1, .pose = {}, .spin = kNan});
  check("spin", 0, {.seq = 1, .pose = {}, .spin = kInfinity});
}

TEST_CASE("not-a-number anywhere in a state is not passed on to the next one in silence") {
  const Poisoned bench;
  const Model& model = bench.model();
  TickReport report = make_report(model);
  Scratch scratch(model);
  const auto check = [&](const char* what, auto&& poison) {
    CAPTURE(what);
    State state = bench.state();
    poison(state);
    const State before = state;
    step(model, bench.no_commands(), state, scratch, report);
    CHECK((report.flags & (kNotFinite | kLawsNotConverged)) != 0);
    if (report.flags & kNotFinite) CHECK(identical(state, before));
  };
  check("tissue x", [](State& s) { s.tissue.x(1, 200) = kNan; });
  check("tissue v", [](State& s) { s.tissue.v(1, 200) = kNan; });
  check("needle x", [](State& s) { s.needles[0].x(0, 3) = kNan; });
  check("needle v", [](State& s) { s.needles[0].v(4, 3) = kNan; });
  check("base", [](State& s) { s.bases[0].velocity.x() = kNan; });

  State state = bench.state();  // and the scratch is as good as before
  State expected = bench.state();
  Scratch fresh(model);
  step(model, bench.no_commands(), expected, fresh, report);
  step(model, bench.no_commands(), state, scratch, report);
  CHECK(identical(state, expected));
}

TEST_CASE("a copy is independent") {
  const Poisoned bench;
  State copy = bench.state();
  copy.tissue.x.setZero();
  copy.paths[0].vertices.clear();
  copy.insertions[0].vertices[0].s = 7;
  CHECK_FALSE(identical(copy, bench.state()));
  CHECK_FALSE(bench.state().tissue.x.isZero());
}

}  // namespace acus::test
