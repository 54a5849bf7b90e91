// SPDX-License-Identifier: GPL-3.0-or-later
// How a path gets longer: straight cuts, through borders and out of the tissue, and slides along a border.
#include <doctest/doctest.h>

#include "server/engine/tick/insertion/transitions/path_growth.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {
namespace {

constexpr double kSpacing = 4e-3;

// Moves the tip so far that the path grows to a place below; returns flags.
std::uint32_t cut_to(InsertionBench& bench, const Vector3& end) {
  bench.put_needle(end - bench.give() * Vector3::UnitZ());
  Path& path = bench.paths[0];
  return in_transition(bench, [&](const Transition& now) { return grow(now, path, path.end.tetrahedron, -1); });
}

void open_mouth(InsertionBench& bench) {
  bench.add_path({on_line(kTop), on_line(kTop)}, kSpacing);
  bench.be_in_path(0);
}

void check_straight(const InsertionBench& bench, std::size_t vertices) {
  const Path& path = bench.paths[0];
  REQUIRE(path.vertices.size() == vertices);
  for (std::size_t i = 0; i < vertices; ++i)
    CHECK((bench.position(path.vertices[i]) - on_line(kTop - static_cast<double>(i) * kSpacing)).norm() < kRounding);
}

// A path that ends on the border at z = 0, its last vertex 2 mm above.
void rest_on_border(InsertionBench& bench) {
  bench.add_straight_path(0);
  bench.paths[0].end = bench.border_point(kLower, on_line(0));
  bench.be_in_path(0);
  bench.state.border = kLower;
}

std::uint32_t slide_to(InsertionBench& bench, double x) {
  const Vector3 tip = on_line(0) + Vector3(x, 0, 0);
  bench.put_needle(tip);
  const MaterialPoint end = bench.border_point(kLower, tip);
  return in_transition(bench, [&](const Transition& now) { return slide(now, bench.paths[0], end); });
}

}  // namespace

TEST_CASE("a straight cut over several ticks has its vertices at exact distances") {
  InsertionBench bench;
  open_mouth(bench);
  for (const double z : {0.0295, 0.0265, 0.0255, 0.0251, 0.0135}) CHECK(cut_to(bench, on_line(z)) == 0);
  check_straight(bench, 5);  // 30, 26, 22, 18, 14 mm
  CHECK(bench.paths[0].tail == doctest::Approx(0.5e-3).epsilon(1e-9));
  CHECK((bench.position(bench.paths[0].end) - on_line(0.0135)).norm() < kRounding);
  CHECK(bench.state.vertices[4].s == doctest::Approx(kLength - 0.5e-3 - bench.give()).epsilon(1e-9));  // behind the tip
  CHECK(bench.state.vertices[3].s == doctest::Approx(kLength - 4.5e-3 - bench.give()).epsilon(1e-9));
  CHECK_FALSE(bench.paths[0].exited);
  CHECK(bench.events.empty());
}

TEST_CASE("a border that holds stops the cut") {
  InsertionBench bench(two_regions(0.7));
  open_mouth(bench);
  CHECK(cut_to(bench, on_line(-3e-3)) == 0);
  check_straight(bench, 8);  // the last at 2 mm
  CHECK((bench.position(bench.paths[0].end) - on_line(0)).norm() < kRounding);
  CHECK(bench.view().tissue.region(bench.paths[0].end) == kUpper);
  CHECK(bench.paths[0].tail == doctest::Approx(2e-3).epsilon(1e-9));
  CHECK(bench.state.border == kLower);
  CHECK(bench.event_kinds() == std::vector{EventKind::contact});
  cut_to(bench, on_line(-3e-3));
  CHECK(bench.events.size() == 1);  // told once
}

TEST_CASE("a border that does not hold is told, and the spacing goes on behind it") {
  InsertionBench bench(two_regions(0.1));
  open_mouth(bench);
  CHECK(cut_to(bench, on_line(-3e-3)) == 0);
  check_straight(bench, 9);  // 2 mm and -2 mm
  CHECK((bench.position(bench.paths[0].end) - on_line(-3e-3)).norm() < kRounding);
  CHECK(bench.state.border == -1);
  REQUIRE(bench.event_kinds() == std::vector{EventKind::crossing});
  CHECK(bench.events[0].region == kLower);
}

TEST_CASE("a cut out of the far face ends on it") {
  InsertionBench bench;
  open_mouth(bench);
  CHECK(cut_to(bench, on_line(kBottom - 5e-3)) == 0);
  CHECK(bench.paths[0].exited);
  CHECK((bench.position(bench.paths[0].end) - on_line(kBottom)).norm() < kRounding);
}

TEST_CASE("a full path takes no more vertices and says so, its end goes on") {
  InsertionBench bench(one_region(), 3);
  open_mouth(bench);
  CHECK(cut_to(bench, on_line(0.0205)) == 0);
  CHECK(cut_to(bench, on_line(0.0105)) == kPathFull);
  check_straight(bench, 3);
  CHECK((bench.position(bench.paths[0].end) - on_line(0.0105)).norm() < kRounding);
}

TEST_CASE("a tip that leaves a border says so once") {
  InsertionBench bench(two_regions(0.7));
  rest_on_border(bench);
  in_transition(bench, [](const Transition& now) {
    leave_border(now);
    leave_border(now);
  });
  CHECK(bench.state.border == -1);
  CHECK(bench.event_kinds() == std::vector{EventKind::release});
}

TEST_CASE("a cut that leaves a border goes on with the force that it had along it") {
  InsertionBench bench(two_regions(0.7));
  rest_on_border(bench);
  bench.put_needle(on_line(0), Vector3(1, 0, -1).normalized());
  bench.state.tip.contact.across = {-0.2, 0, 0};
  in_transition(bench, [](const Transition& now) { leave_border(now); });
  CHECK(bench.state.tip.cut.along == doctest::Approx(0.2 / std::sqrt(2)).epsilon(1e-9));
  bench.state.border = kLower;
  bench.state.tip = {};
  bench.state.tip.contact.across = {0.2, 0, 0};  // pulled back
  in_transition(bench, [](const Transition& now) { leave_border(now); });
  CHECK(bench.state.tip.cut.along == 0);
}

TEST_CASE("a short slide moves the end, and its tail is the straight distance") {
  InsertionBench bench(two_regions(0.7));
  rest_on_border(bench);
  CHECK(slide_to(bench, 1.5e-3) == 0);
  CHECK(bench.paths[0].vertices.size() == 8);
  CHECK(bench.paths[0].tail == doctest::Approx(2.5e-3).epsilon(1e-9));  // 1.5 aside, 2 down
}

TEST_CASE("a slide over many spacings in one tick lays a vertex at each") {
  InsertionBench bench(two_regions(0.7));
  rest_on_border(bench);
  CHECK(slide_to(bench, 13.1e-3) == 0);
  const Path& path = bench.paths[0];
  REQUIRE(path.vertices.size() == 11);
  // The first at 4 mm from the vertex 2 mm above, the others along the border.
  const double first = std::sqrt(16.0 - 4.0) * 1e-3;
  for (int i = 0; i < 3; ++i) {
    const MaterialPoint& vertex = path.vertices[static_cast<std::size_t>(8 + i)];
    CHECK((bench.position(vertex) - on_line(0) - Vector3(first + i * kSpacing, 0, 0)).norm() < kRounding);
    CHECK(bench.view().tissue.border_face(vertex));
    CHECK(bench.view().tissue.region(vertex) == kUpper);
  }
  CHECK(path.tail == doctest::Approx(13.1e-3 - first - 2 * kSpacing).epsilon(1e-9));
}

TEST_CASE("slow and fast slides lay the same vertices") {
  InsertionBench slow(two_regions(0.7)), fast(two_regions(0.7));
  rest_on_border(slow);
  rest_on_border(fast);
  for (int i = 1; i <= 26; ++i) slide_to(slow, i * 0.5e-3);
  slide_to(fast, 13e-3);
  REQUIRE(slow.paths[0].vertices.size() == fast.paths[0].vertices.size());
  for (std::size_t i = 0; i < slow.paths[0].vertices.size(); ++i)
    CHECK((slow.position(slow.paths[0].vertices[i]) - fast.position(fast.paths[0].vertices[i])).norm() < kRounding);
  CHECK(slow.paths[0].tail == doctest::Approx(fast.paths[0].tail).epsilon(1e-9));
}

TEST_CASE("a tip that slides back drops the vertices that it comes over") {
  InsertionBench bench(two_regions(0.7));
  rest_on_border(bench);
  slide_to(bench, 13.1e-3);
  CHECK(slide_to(bench, 5e-3) == 0);
  CHECK(bench.paths[0].vertices.size() == 9);  // the one at 3.46 mm stays
  CHECK(bench.paths[0].tail == doctest::Approx(5e-3 - std::sqrt(12.0) * 1e-3).epsilon(1e-9));
}

TEST_CASE("a slide with a full path says so") {
  InsertionBench bench(two_regions(0.7), 9);
  rest_on_border(bench);
  CHECK(slide_to(bench, 13.1e-3) == kPathFull);
  CHECK(bench.paths[0].vertices.size() == 9);
  CHECK((bench.position(bench.paths[0].end) - on_line(0) - Vector3(13.1e-3, 0, 0)).norm() < kRounding);
}

}  // namespace acus::test
