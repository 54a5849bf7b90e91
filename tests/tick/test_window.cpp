// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes with a deferred field: needles meet what they meet without it, states go on bit by bit from any tick of a
// window, with a thread for it or without, and scenes that cannot have one are refused.
#include <doctest/doctest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "server/engine/math/random.h"
#include "server/engine/models/field/field_tick.h"
#include "server/engine/scene/field_error.h"
#include "server/engine/state/bytes/adoption.h"
#include "server/engine/state/bytes/snapshot.h"
#include "server/engine/state/bytes/state_bytes.h"
#include "tests/tick/bench.h"

namespace acus::test {
namespace {

Scene windowed(int window, bool thread = false) {
  Scene scene = block_scene();
  scene.tissue.window = window;
  scene.tissue.window_thread = thread;
  return scene;
}

struct Felt {
  std::vector<Vector3> forces, tips;
  double largest = 0;
};

// In at an angle that bends the needle, turning, a stop, and out again.
Felt feel(int window) {
  Bench bench(windowed(window));
  Felt felt;
  bench.each_tick = [&] {
    felt.forces.push_back(bench.needle().base_force);
    felt.tips.push_back(bench.needle().tip_position);
    felt.largest = std::max(felt.largest, bench.needle().base_force.norm());
    if (window > 0) CHECK(bench.simulation().state().tissue.field->window->share == 1);
  };
  bench.push(0, 0.025, 0.03);
  bench.spin(0, 1.5, 6);
  bench.move(0, {0.002, 0.001, 0}, 0.01);
  bench.wait(0.3);
  bench.push(0, -0.03, 0.05);
  bench.wait(0.3);
  CHECK(bench.finite());
  return felt;
}

template <class List>
double share_above(const List& list, double limit) {
  return static_cast<double>(std::ranges::count_if(list, [&](double x) { return x > limit; })) / static_cast<double>(list.size());
}

}  // namespace

TEST_CASE("forces and tips are those of the tissue that moves at every tick" * doctest::test_suite("gate")) {
  const Felt every_tick = feel(0);
  REQUIRE(every_tick.largest > 0.2);
  for (const int window : {1, 4, 8, 16}) {
    CAPTURE(window);
    const Felt felt = feel(window);
    std::vector<double> force, tip;
    for (std::size_t i = 0; i < felt.forces.size(); ++i) {
      force.push_back((felt.forces[i] - every_tick.forces[i]).norm());
      tip.push_back((felt.tips[i] - every_tick.tips[i]).norm());
    }
    CHECK(share_above(force, 1e-3 * every_tick.largest) < 0.05);
    CHECK(share_above(force, 5e-3 * every_tick.largest) < 0.01);
    CHECK(share_above(tip, 10e-6) < 0.05);
    CHECK(force.back() < 1e-5);
  }
}

TEST_CASE("another simulation goes on bit by bit from a snapshot of any tick of a window") {
  const Scene scene = windowed(6);
  Bench bench(scene);
  Simulation other(scene);
  bench.push(0, 0.012, 0.05);
  for (int phase = 0; phase < 8; ++phase) {
    CAPTURE(phase);
    const State& state = bench.simulation().state();
    other.restore(read_snapshot(other.model(), make_snapshot(other.model().fingerprint, state)));
    REQUIRE(identical(other.state(), state));
    Simulation one(scene);
    one.restore(state);
    for (int i = 0; i < 20; ++i) {
      one.step();
      other.step();
      REQUIRE(hash(one.state()) == hash(other.state()));
    }
    bench.push(0, 0.0001, 0.1);
  }
}

TEST_CASE("a window's thread gives the same bits") {
  std::vector<std::uint64_t> hashes;
  for (const bool thread : {false, true}) {
    Bench bench(windowed(6, thread));
    std::size_t tick = 0;
    bench.each_tick = [&] {
      const std::uint64_t now = hash(bench.simulation().state());
      if (thread)
        REQUIRE(now == hashes.at(tick++));
      else
        hashes.push_back(now);
    };
    bench.push(0, 0.02, 0.05);
    bench.move(0, {0.001, 0, 0}, 0.02);
    bench.push(0, -0.03, 0.1);
    REQUIRE(hashes.size() > 300);
  }
}

TEST_CASE("a window's thread may be broken off in its work at any time") {
  Bench bench(windowed(6));
  std::vector<State> states;
  bench.each_tick = [&] { states.push_back(bench.simulation().state()); };
  bench.push(0, 0.015, 0.05);
  Simulation plain(windowed(6)), threaded(windowed(6, true));
  CHECK(plain.model().fingerprint == threaded.model().fingerprint);
  Random random(1);
  for (int i = 0; i < 60; ++i) {
    const State& state = states[static_cast<std::size_t>(random.index(static_cast<int>(states.size())))];
    const int ticks = 1 + random.index(14);
    for (Simulation* simulation : {&plain, &threaded}) {
      simulation->restore(state);
      for (int tick = 0; tick < ticks; ++tick) simulation->step();
    }
    REQUIRE(hash(plain.state()) == hash(threaded.state()));
  }
}

TEST_CASE("a copy of the process has no thread for windows, and goes on without") {
  auto threaded = std::make_unique<Simulation>(windowed(6, true));
  Simulation plain(windowed(6));
  const auto step = [](Simulation& of, int ticks) {
    for (int tick = 0; tick < ticks; ++tick) of.step();
    return hash(of.state());
  };
  REQUIRE(step(*threaded, 9) == step(plain, 9));
  const std::uint64_t expected = step(plain, 20);
  std::fflush(nullptr);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const bool same = step(*threaded, 20) == expected;
    threaded.reset();
    _exit(same ? 0 : 1);
  }
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(status == 0);
  CHECK(step(*threaded, 20) == expected);
}

TEST_CASE("a state that is kept stays as it is while others go on from it") {
  Bench bench(windowed(4));
  bench.push(0, 0.012, 0.05);
  const State kept = bench.simulation().state();
  const std::uint64_t before = hash(kept);
  bench.push(0, 0.005, 0.05);
  CHECK(hash(kept) == before);
}

TEST_CASE("held nodes are those about the needle, and are let go behind it") {
  Bench bench(windowed(4));
  bench.push(0, 0.02, 0.05);
  const FieldState& field = *bench.simulation().state().tissue.field;
  CHECK(field.held.size() >= 8);
  CHECK(field.held.size() < 80);
  bench.push(0, -0.03, 0.05);
  CHECK(field.held.size() < 5);
}

TEST_CASE("a snapshot with held nodes that cannot be is refused") {
  Bench bench(windowed(4));
  bench.push(0, 0.012, 0.05);
  const Model& model = bench.simulation().model();
  const auto refused = [&](const std::function<void(State&)>& forge) {
    State state = bench.simulation().state();
    forge(state);
    CHECK_THROWS_AS(read_snapshot(model, make_snapshot(model.fingerprint, state)), SnapshotError);
  };
  refused([](State& state) { state.tissue.field->held[0].free = -1; });
  refused([](State& state) { state.tissue.field->held[0].free = 1'000'000; });
  refused([](State& state) { state.tissue.field->held[0].free = state.tissue.field->held[1].free; });
  refused([](State& state) { state.tissue.field->tick = -1; });
  refused([](State& state) { state.tissue.field->tick = 5; });
}

// With the right checksum, numbers of 1e12 made 239 MN.
TEST_CASE("a snapshot whose numbers no window can hold is refused, an honest one of any tick is not") {
  Bench bench(windowed(4));
  bench.push(0, 0.012, 0.05);
  const Model& model = bench.simulation().model();
  const auto check = [&](const State& state) { return read_snapshot(model, make_snapshot(model.fingerprint, state)); };
  for (int tick = 0; tick < 9; ++tick) {
    CHECK_NOTHROW(check(bench.simulation().state()));
    bench.push(0, 1e-4, 0.05);
  }
  const auto refused = [&](const char* what, const std::function<void(FieldState&, FieldWindow&)>& forge) {
    CAPTURE(what);
    State state = bench.simulation().state();
    FieldState& field = *state.tissue.field;
    const auto window = std::make_shared<FieldWindow>(*field.window);
    forge(field, *window);
    field.window = window;
    CHECK_THROWS_AS(check(state), SnapshotError);
  };
  constexpr double kMuch = 1e12;
  for (double FieldShares::*share :
       {&FieldShares::carried, &FieldShares::fed, &FieldShares::carried_sum, &FieldShares::fed_sum}) {
    refused("share", [&](FieldState& field, FieldWindow&) { field.shares.*share = kMuch; });
    refused("share", [&](FieldState& field, FieldWindow&) { field.shares.*share += 0.1; });
  }
  for (VectorX FieldWindow::*part :
       {&FieldWindow::y_moved, &FieldWindow::modes_moved, &FieldWindow::inertia, &FieldWindow::p, &FieldWindow::y,
        &FieldWindow::modes, &FieldWindow::defect, &FieldWindow::y_defect, &FieldWindow::modes_defect,
        &FieldWindow::scheduled, &FieldWindow::total})
    refused("vector of a window", [&](FieldState&, FieldWindow& window) { (window.*part)[1] = -kMuch; });
  for (VectorX FieldWindow::*part : {&FieldWindow::p, &FieldWindow::y, &FieldWindow::defect, &FieldWindow::y_defect})
    refused("no image of the other", [&](FieldState&, FieldWindow& window) { (window.*part)[1] += 10; });
  for (double FieldWindow::*number : {&FieldWindow::size, &FieldWindow::scale, &FieldWindow::increase})
    refused("number of a window", [&](FieldState&, FieldWindow& window) { window.*number = kMuch; });
  refused("left", [&](FieldState&, FieldWindow& window) { window.left[2] = kMuch; });
  refused("x", [&](FieldState&, FieldWindow& window) { window.x(0, 3) = kMuch; });
  for (VectorX FieldState::*part : {&FieldState::d, &FieldState::d_before, &FieldState::modes_moved})
    refused("vector of a field", [&](FieldState& field, FieldWindow&) { (field.*part)[0] = kMuch; });
  for (Vector3 HeldNode::*part : {&HeldNode::x, &HeldNode::p, &HeldNode::sum, &HeldNode::force}) {
    refused("held node", [&](FieldState& field, FieldWindow&) { (field.held[0].*part)[0] = kMuch; });
    refused("held node of a window", [&](FieldState&, FieldWindow& window) { (window.held[0].*part)[0] = kMuch; });
  }
}

TEST_CASE("scenes that cannot have a deferred field are refused with the reason") {
  const auto refusal = [](const std::function<void(Scene&)>& change) {
    Scene scene = windowed(8);
    change(scene);
    try {
      const Simulation simulation(scene);
      return std::string();
    } catch (const SceneError& error) {
      return std::string(error.what());
    }
  };
  CHECK(refusal([](Scene&) {}).empty());
  const auto says = [&](const std::function<void(Scene&)>& change, const char* what) {
    const std::string said = refusal(change);
    CAPTURE(said);
    CHECK(said.find(what) != std::string::npos);
  };
  says([](Scene& scene) { scene.tissue.rung = TissueRung::refined; }, "tissue.window: expected 0 with another rung than warped");
  says([](Scene& scene) { scene.tissue.element = TissueElement::nodal_pressure; }, "expected 0 with element nodal_pressure");
  says([](Scene& scene) { scene.tissue.regions[0].material.poisson_ratio = 0.49; }, "poisson_ratio above 0.47");
  says([](Scene& scene) { scene.tissue.regions[0].material.rayleigh_stiffness = 0; }, "no rayleigh_stiffness");
  says(
      [](Scene& scene) {
        scene.tissue.window = 0;
        scene.tissue.window_thread = true;
      },
      "tissue.window_thread: expected false without a window");
  says([](Scene& scene) { scene.tissue.fixed.clear(); }, "tissue.window: expected 0 for tissue that supports do not hold");
}

}  // namespace acus::test
