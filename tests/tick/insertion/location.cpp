// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 4 of one needle: surfaces, mouths of paths, vertices alongside and what they own.
#include <doctest/doctest.h>

#include "server/engine/tick/insertion/owned_lengths.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {
namespace {

double sum_of_owned(std::span<const ShaftPoint> shaft) {
  double sum = 0;
  for (const ShaftPoint& point : shaft) sum += point.owned;
  return sum;
}

bool same_place(const MaterialPoint& a, const MaterialPoint& b) {
  return a.tetrahedron == b.tetrahedron && a.weights == b.weights;
}

bool same_path(const Path& a, const Path& b) {
  if (a.vertices.size() != b.vertices.size() || !same_place(a.end, b.end)) return false;
  for (std::size_t i = 0; i < a.vertices.size(); ++i)
    if (!same_place(a.vertices[i], b.vertices[i])) return false;
  return a.needle == b.needle && a.exited == b.exited && a.head == b.head && a.tail == b.tail && a.left == b.left;
}

}  // namespace

TEST_CASE("a vertex owns the needle halfway to its neighbours, from the surface to the tip") {
  std::vector<ShaftPoint> shaft{
      {.vertex = 0, .s = 0.090, .mouth = true}, {.vertex = 1, .s = 0.094}, {.vertex = 2, .s = 0.097}};
  share_length(shaft, 0.100);
  CHECK(shaft[0].owned == doctest::Approx(0.0020).epsilon(1e-12));
  CHECK(shaft[1].owned == doctest::Approx(0.0035).epsilon(1e-12));
  CHECK(shaft[2].owned == doctest::Approx(0.0045).epsilon(1e-12));
  CHECK(sum_of_owned(shaft) == doctest::Approx(0.010).epsilon(1e-12));
  CHECK(shaft[1].supported == shaft[1].owned);
  CHECK(shaft[2].supported == doctest::Approx(0.0030).epsilon(1e-12));
  share_length(shaft, 0.100, false);
  CHECK(shaft[2].supported == shaft[2].owned);
}

TEST_CASE("nobody owns the air between two parts of a path") {
  std::vector<ShaftPoint> shaft{{.vertex = 0, .s = 0.080, .mouth = true},
                                {.vertex = 1, .s = 0.084, .exit = true},
                                {.vertex = 2, .s = 0.094, .mouth = true},
                                {.vertex = 3, .s = 0.098}};
  share_length(shaft, 0.100);
  CHECK(shaft[1].owned == doctest::Approx(0.002).epsilon(1e-12));
  CHECK(shaft[2].owned == doctest::Approx(0.002).epsilon(1e-12));
  CHECK(sum_of_owned(shaft) == doctest::Approx(0.010).epsilon(1e-12));
}

TEST_CASE("where the mouth has passed the base, the first vertex owns the needle from its base") {
  std::vector<ShaftPoint> shaft{{.vertex = 3, .s = 0.010}, {.vertex = 4, .s = 0.020}};
  share_length(shaft, 0.022);
  CHECK(shaft[0].owned == doctest::Approx(0.015).epsilon(1e-12));
  CHECK(shaft[1].owned == doctest::Approx(0.007).epsilon(1e-12));
}

TEST_CASE("owned lengths sum to the inserted length whatever vertices there are") {
  for (const double z : {0.0295, 0.0281, 0.026, 0.0219, 0.0173, 0.0101}) {
    InsertionBench bench;
    bench.add_straight_path(z, 3e-3);
    bench.be_in_path(0);
    bench.put_needle(on_line(z));
    const Located& located = bench.locate();
    CHECK(sum_of_owned({located.shaft.begin(), located.shaft.end()}) == doctest::Approx(kTop - z).epsilon(1e-10));
  }
}

TEST_CASE("vertices stand along the needle where their planes across the path cut it") {
  InsertionBench bench;
  bench.add_straight_path(0.020);
  bench.be_in_path(0);
  bench.put_needle(on_line(0.020) + Vector3(4e-4, 0, 0));  // beside its path
  const Located& located = bench.locate();
  REQUIRE(located.shaft.size() == 3);
  for (int i = 0; i < 3; ++i) {
    CHECK(located.shaft[i].vertex == i);
    CHECK(located.shaft[i].s == doctest::Approx(0.090 + 0.004 * i).epsilon(1e-10));
    CHECK((located.shaft[i].tangent + Vector3::UnitZ()).norm() < kRounding);
  }
  CHECK(bench.scratch.next.end_s == doctest::Approx(kLength).epsilon(1e-10));
  CHECK(bench.scratch.next.first_alongside == 0);
  CHECK(bench.scratch.next.last_alongside == 2);
}

TEST_CASE("a vertex that comes alongside takes over the traction of the one before it") {
  InsertionBench bench;
  bench.add_straight_path(0.020);
  bench.be_in_path(0);
  bench.state.first_alongside = 0;
  bench.state.last_alongside = 1;
  bench.state.vertices[0].traction = 3;
  bench.state.vertices[1].traction = 5;
  bench.state.vertices[2].traction = 9;  // of an earlier time
  bench.put_needle(on_line(0.020));
  bench.locate();
  CHECK(bench.scratch.next.vertices[0].traction == 3);
  CHECK(bench.scratch.next.vertices[1].traction == 5);
  CHECK(bench.scratch.next.vertices[2].traction == 5);
}

TEST_CASE("what vertices bore that the tip is pulled past goes to the last one alongside") {
  InsertionBench bench;
  bench.add_straight_path(0.010);
  bench.be_in_path(0);
  bench.state.first_alongside = 0;
  bench.state.last_alongside = 4;
  for (int i = 0; i < 5; ++i) {
    bench.state.vertices[i].contact.along = i + 1;
    bench.state.vertices[i].traction = 100 * i;
  }
  bench.put_needle(on_line(0.020));
  const Located& located = bench.locate();
  const auto& next = bench.scratch.next.vertices;
  REQUIRE(located.shaft.size() == 3);
  CHECK(next[2].contact.along == 3 + 4 + 5);
  CHECK(next[2].traction == doctest::Approx(12 / 0.004).epsilon(1e-10));  // from 6 to 10 mm
  CHECK(next[1].contact.along == 2);
  CHECK(next[1].traction == 100);
}

TEST_CASE("far from the tissue a needle finds nothing") {
  InsertionBench bench;
  bench.put_needle(on_line(0.04));
  const Located& located = bench.locate();
  CHECK_FALSE(located.obstacle);
  CHECK(located.shaft.empty());
  CHECK(bench.scratch.next.path == -1);
}

TEST_CASE("a tip near the surface, or that goes through it in the tick, finds the point under it") {
  InsertionBench bench;
  bench.put_needle(on_line(kTop + 5e-4));
  SUBCASE("near") {}
  SUBCASE("through") { bench.move_needle(on_line(kTop - 5e-4)); }
  const Located& located = bench.locate();
  REQUIRE(located.obstacle);
  CHECK(located.obstacle->region == 0);
  CHECK((located.obstacle->at.position - on_line(kTop)).norm() < kRounding);
  CHECK((located.obstacle->at.normal - Vector3::UnitZ()).norm() < kRounding);
  CHECK((bench.position(located.obstacle->material) - on_line(kTop)).norm() < kRounding);
  CHECK(bench.scratch.next.path == -1);
}

TEST_CASE("a needle that goes into an open mouth picks the path up and leaves it as it is") {
  InsertionBench bench;
  const Path before = bench.add_straight_path(0.010);
  bench.put_needle(on_line(kTop + 1e-3));
  bench.move_needle(on_line(kTop - 1e-3));
  const Located& located = bench.locate();
  CHECK(located.reentered);
  CHECK_FALSE(located.far_end);
  CHECK_FALSE(located.obstacle);
  CHECK(bench.scratch.next.path == 0);
  CHECK(bench.paths_taken[0] == 1);
  CHECK(same_path(bench.paths[0], before));
  REQUIRE(located.shaft.size() == 1);
  CHECK(located.shaft[0].s == doctest::Approx(kLength - 1e-3).epsilon(1e-10));
  CHECK(bench.state.path == -1);
}

TEST_CASE("from where it left the tissue a path is picked up turned round") {
  InsertionBench bench;
  bench.add_straight_path(kBottom).exited = true;
  const Path before = bench.paths[0];
  bench.put_needle(on_line(kBottom - 1e-3), Vector3::UnitZ());
  bench.move_needle(on_line(kBottom + 1e-3), Vector3::UnitZ());
  const Located& located = bench.locate();
  CHECK(located.reentered);
  CHECK(located.far_end);
  CHECK(same_path(bench.paths[0], before));
  const Path& seen = bench.scratch.path(bench.paths);
  CHECK(same_place(seen.vertices[0], before.end));
  CHECK(same_place(seen.end, before.vertices[0]));
  REQUIRE(located.shaft.size() == 1);
  CHECK((located.shaft[0].tangent - Vector3::UnitZ()).norm() < kRounding);
}

TEST_CASE("an end inside the tissue is no mouth") {
  InsertionBench bench;
  bench.add_straight_path(kBottom);
  bench.put_needle(on_line(kBottom - 1e-3), Vector3::UnitZ());
  bench.move_needle(on_line(kBottom + 1e-3), Vector3::UnitZ());
  CHECK_FALSE(bench.locate().reentered);
}

TEST_CASE("a mouth further away than a needle's diameter is another place of the surface") {
  InsertionBench bench;
  bench.add_straight_path(0.010);
  const Vector3 beside(1.1 * kDiameter, 0, 0);
  bench.put_needle(on_line(kTop + 1e-3) + beside);
  bench.move_needle(on_line(kTop - 1e-3) + beside);
  CHECK_FALSE(bench.locate().reentered);
  CHECK(bench.scratch.located.obstacle);
}

TEST_CASE("two needles do not pick up the same path in one tick") {
  InsertionBench bench;
  bench.add_straight_path(0.010);
  bench.put_needle(on_line(kTop + 1e-3));
  bench.move_needle(on_line(kTop - 1e-3));
  bench.locate();
  InsertionScratch second = bench.scratch;
  locate_insertion(bench.view(), bench.state, bench.paths, bench.paths_taken, second);
  CHECK(bench.scratch.next.path == 0);
  CHECK(second.next.path == -1);
  CHECK_FALSE(second.located.reentered);
}

TEST_CASE("a path that another needle is in, or has picked up in this tick, is not picked up again") {
  InsertionBench bench;
  Path& path = bench.add_straight_path(0.010);
  SUBCASE("is in") { path.needle = 1; }
  SUBCASE("has picked up") { bench.paths_taken[0] = 1; }
  bench.put_needle(on_line(kTop + 1e-3));
  bench.move_needle(on_line(kTop - 1e-3));
  CHECK_FALSE(bench.locate().reentered);
  CHECK(bench.scratch.next.path == -1);
}

}  // namespace acus::test
