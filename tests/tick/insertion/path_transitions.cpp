// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 9 of one needle: puncture, growth, exit, withdrawal, re-entry.
#include <doctest/doctest.h>

#include "server/engine/math/rotation.h"
#include "server/engine/tick/insertion/transitions/path_transitions.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {
namespace {

std::uint32_t transitions_of(InsertionBench& bench) {
  return in_transition(bench, [](const Transition& now) { return insertion_transitions(now); });
}

// As stages 4 to 8 leave it: the tip so far through the surface after it pressed with f_p that it cuts 0.5 mm.
void press_through(InsertionBench& bench) {
  bench.state.phase = Phase::contact;
  bench.state.touched = bench.point(on_line(kTop));
  bench.put_needle(on_line(kTop));
  bench.move_needle(on_line(kTop - 5e-4 - bench.give()));
  bench.locate();
  bench.state = bench.scratch.next;
  bench.state.tip.contact.along = 0.4;
  bench.scratch.puncturing = true;
}

// The needle goes straight down for 40 mm from its base and then turns back up, on a half circle of 20 mm.
void put_hooked_needle(InsertionBench& bench, const Vector3& base) {
  constexpr double kStraight = 0.04, kRadius = 0.02;
  NeedleState needle = make_needle_state(bench.model, Pose{});
  for (Eigen::Index i = 0; i < needle.x.cols(); ++i) {
    const double s = needle.x(0, i);
    const double angle = std::max(0.0, s - kStraight) / kRadius;
    const double down = std::min(s, kStraight) + kRadius * std::sin(angle);
    needle.x.col(i) = base + Vector3(kRadius * (1 - std::cos(angle)), 0, -down);
    needle.q[static_cast<std::size_t>(i)] =
        rotation_between(Vector3::UnitX(), Vector3(std::sin(angle), 0, -std::cos(angle)));
  }
  put_shape(needle, bench.start);
  bench.shape = bench.start;
}

}  // namespace

TEST_CASE("contact and release are told") {
  InsertionBench bench;
  bench.put_needle(on_line(kTop));
  bench.locate();
  bench.state.tip.contact.along = 0.1;
  transitions_of(bench);
  CHECK(bench.state.phase == Phase::contact);
  bench.state.tip.contact.along = 0;
  transitions_of(bench);
  CHECK(bench.state.phase == Phase::free);
  CHECK(bench.event_kinds() == std::vector{EventKind::contact, EventKind::release});
}

TEST_CASE("a puncture opens a path where the needle goes through the surface") {
  InsertionBench bench;
  press_through(bench);
  CHECK(transitions_of(bench) == 0);
  CHECK(bench.event_kinds() == std::vector{EventKind::puncture});
  CHECK(bench.events[0].tick == kTick);
  CHECK(bench.events[0].force == 0.4);
  REQUIRE(bench.state.path == 0);
  CHECK(bench.state.phase == Phase::inside);
  const Path& path = bench.paths[0];
  CHECK(path.needle == 0);
  CHECK(path.spacing == bench.parameters.constraint_spacing);
  REQUIRE(path.vertices.size() == 1);
  CHECK((bench.position(path.vertices[0]) - on_line(kTop)).norm() < kRounding);
  CHECK((bench.position(path.end) - on_line(kTop - 5e-4)).norm() < kRounding);
  CHECK(path.tail == doctest::Approx(5e-4).epsilon(1e-9));
  CHECK(bench.state.depth == doctest::Approx(5e-4 + bench.give()).epsilon(1e-9));
}

TEST_CASE("a tip that presses an element flat punctures, whatever force it takes") {
  InsertionBench bench;
  bench.put_needle(on_line(kTop));
  bench.locate();
  bench.state.tip.contact.along = 0.1;
  for (const int node : bench.mesh.tetrahedra[static_cast<std::size_t>(bench.point(on_line(kTop)).tetrahedron)])
    if (bench.mesh.nodes(2, node) > kTop - 1e-6) bench.x(2, node) -= 0.015;  // through the node below
  transitions_of(bench);
  CHECK(bench.event_kinds() == std::vector{EventKind::contact, EventKind::puncture});
  CHECK(bench.events[1].force == 0.1);
  CHECK(bench.state.phase == Phase::inside);
}

TEST_CASE("a tip that is found in the tissue without path or contact gets a path along its way") {
  InsertionBench bench;
  const double depth = 5e-3;
  bench.put_needle(on_line(kTop - depth));
  bench.locate();
  CHECK(transitions_of(bench) == kTipFoundInside);
  CHECK(bench.event_kinds() == std::vector{EventKind::intrusion});
  CHECK(bench.state.phase == Phase::inside);
  CHECK(bench.state.depth == doctest::Approx(depth).epsilon(1e-9));
  REQUIRE(bench.state.path == 0);
  CHECK((bench.position(bench.paths[0].vertices[0]) - on_line(kTop)).norm() < kRounding);
  CHECK((bench.position(bench.paths[0].end) - on_line(kTop - depth)).norm() < kRounding);
}

TEST_CASE("a tip that slides off its patch to where the surface is higher stays in contact") {
  InsertionBench bench;
  bench.state.phase = Phase::contact;
  bench.state.touched = bench.point(on_line(kTop));
  bench.put_needle(on_line(kTop));
  const Vector3 slid = on_line(kTop - 2e-3) + Vector3(6e-3, 0, 0);
  bench.move_needle(slid);
  bench.locate();
  CHECK(transitions_of(bench) == 0);
  CHECK(bench.events.empty());
  CHECK(bench.state.phase == Phase::contact);
  CHECK((bench.position(bench.state.touched) - Vector3(slid.x(), slid.y(), kTop)).norm() < kRounding);
}

TEST_CASE("the path of a bent needle that is found in the tissue lies along its shaft, and bears nothing") {
  InsertionBench bench;
  put_hooked_needle(bench, {-0.0191, 0.0021, kTop + 0.02});
  bench.locate();
  CHECK(transitions_of(bench) == kTipFoundInside);
  const Path& path = bench.paths[0];
  CHECK((bench.position(path.vertices[0]) - Vector3(-0.0191, 0.0021, kTop)).norm() < 1e-6);
  CHECK(bench.state.depth == doctest::Approx(kLength - 0.02).epsilon(0.01));
  const auto& needle = bench.view().needle;
  for (std::size_t k = 0; k < path.vertices.size(); ++k) {
    const Vector3 on_shaft = curve_point(needle.model, needle.shape, bench.state.vertices[k].s).position;
    const double sagitta = path.spacing * path.spacing / (8 * 0.02);
    CHECK((bench.position(path.vertices[k]) - on_shaft).norm() < 2 * sagitta);
  }
}

TEST_CASE("a tip that has just punctured may stand before the mouth; one that goes back is withdrawn") {
  InsertionBench bench;
  bench.add_straight_path(kTop - 5e-3);
  bench.be_in_path(0);
  bench.state.depth = 0;
  bench.put_needle(on_line(kTop + 2e-4));
  bench.move_needle(on_line(kTop + 1e-4));
  bench.locate();
  transitions_of(bench);
  CHECK(bench.state.phase == Phase::inside);
  bench.put_needle(on_line(kTop + 1e-4));
  bench.move_needle(on_line(kTop + 2e-4));
  bench.locate();
  transitions_of(bench);
  CHECK(bench.event_kinds() == std::vector{EventKind::withdrawal});
}

TEST_CASE("a tip whose mouth is dragged past it is in the tissue, and stays in its path") {
  InsertionBench bench;
  Path& path = bench.add_straight_path(0.010);
  bench.be_in_path(0);
  bench.state.depth = 1e-3;
  path.vertices[0] = bench.point(on_line(kTop - 8e-3));
  bench.put_needle(on_line(kTop - 4e-3));
  bench.locate();
  transitions_of(bench);
  CHECK(bench.state.phase == Phase::inside);
  CHECK(bench.events.empty());
}

TEST_CASE("a tip that is through and is found in the tissue: its path goes on there") {
  InsertionBench bench;
  Path& path = bench.add_straight_path(0.020);
  path.exited = true;
  bench.be_in_path(0);
  bench.state.phase = Phase::through;
  bench.put_needle(on_line(0.010));
  bench.locate();
  bench.state = bench.scratch.next;
  CHECK(transitions_of(bench) == kTipFoundInside);
  CHECK(bench.event_kinds() == std::vector{EventKind::intrusion});
  CHECK(bench.state.phase == Phase::inside);
  CHECK_FALSE(path.exited);
  REQUIRE(path.exits.size() == 1);
  CHECK((bench.position(path.end) - on_line(0.010)).norm() < kRounding);
}

TEST_CASE("a puncture takes the place of the path that was left longest ago, and none where all are in use") {
  InsertionBench bench;
  for (int i = 0; i < 3; ++i) bench.add_straight_path(0.010).left = static_cast<std::uint64_t>(5 - i);
  for (Path& path : bench.paths) path.vertices[0] = bench.point({-0.02, -0.02, kTop});  // not under the tip
  bench.paths[2].needle = 1;
  bool opens = true;
  SUBCASE("one is free") {}
  SUBCASE("all are in use") {
    bench.paths[0].needle = bench.paths[1].needle = 2;
    opens = false;
  }
  press_through(bench);
  transitions_of(bench);
  CHECK(bench.state.path == (opens ? 1 : -1));
  CHECK(bench.events.empty() != opens);
}

TEST_CASE("a tip that cuts takes the end along, one that does not leaves it") {
  InsertionBench bench;
  bench.add_straight_path(0.020);
  bench.be_in_path(0);
  bench.put_needle(on_line(0.019 - bench.give()));
  bench.locate();
  bench.state = bench.scratch.next;
  bench.scratch.cutting = false;
  transitions_of(bench);
  CHECK((bench.position(bench.paths[0].end) - on_line(0.020)).norm() < kRounding);
  bench.scratch.cutting = true;
  transitions_of(bench);
  CHECK((bench.position(bench.paths[0].end) - on_line(0.019)).norm() < kRounding);
  CHECK(bench.events.empty());
}

TEST_CASE("a tip that cuts out of the tissue, goes back and comes again") {
  InsertionBench bench;
  bench.add_straight_path(kBottom + 1e-3);
  bench.be_in_path(0);
  const double out = kBottom - 1e-3 - bench.give();
  for (const double z : {out, kBottom + 1e-3, out}) {
    bench.put_needle(on_line(z));
    bench.locate();
    bench.state = bench.scratch.next;
    bench.scratch.cutting = true;
    transitions_of(bench);
    CHECK(bench.paths[0].exited);
    CHECK(bench.state.phase == (z < kBottom ? Phase::through : Phase::inside));
  }
  CHECK(bench.event_kinds() == std::vector{EventKind::exit, EventKind::reentry, EventKind::exit});
}

TEST_CASE("withdrawal frees the path and keeps it") {
  InsertionBench bench;
  bench.add_straight_path(0.010);
  bench.be_in_path(0);
  bench.state.depth = 1e-3;
  bench.put_needle(on_line(kTop + 1e-3));
  bench.locate();
  transitions_of(bench);
  CHECK(bench.event_kinds() == std::vector{EventKind::withdrawal});
  CHECK(bench.paths[0].needle == -1);
  CHECK(bench.paths[0].left == kTick);
  CHECK(bench.paths[0].vertices.size() == 5);
  CHECK(bench.state.path == -1);
  CHECK(bench.state.phase == Phase::free);
}

TEST_CASE("re-entry takes the path, from its far end turned round") {
  InsertionBench bench;
  bench.add_straight_path(kBottom).exited = true;
  bool far_end = false;
  SUBCASE("from the mouth") {}
  SUBCASE("from the far end") { far_end = true; }
  const double side = far_end ? -1 : 1;
  const Vector3 along = -side * Vector3::UnitZ();
  bench.put_needle(on_line(side * (kTop + 1e-3)), along);
  bench.move_needle(on_line(side * (kTop - 1e-3)), along);
  REQUIRE(bench.locate().reentered);
  bench.state = bench.scratch.next;
  transitions_of(bench);
  const Path& path = bench.paths[0];
  CHECK(bench.event_kinds().front() == EventKind::reentry);
  CHECK(path.needle == 0);
  CHECK(bench.state.path == 0);
  CHECK((bench.position(path.vertices[0]) - on_line(side * kTop)).norm() < kRounding);
  CHECK((bench.position(path.end) - on_line(-side * kTop)).norm() < kRounding);
}

}  // namespace acus::test
