// SPDX-License-Identifier: GPL-3.0-or-later
// What the laws' forces mean for a needle, with forces that are given.
#include <doctest/doctest.h>

#include "server/engine/tick/insertion/forces.h"
#include "tests/tick/insertion/bench_insertion.h"

namespace acus::test {

TEST_CASE("forces are summed by law and remembered by vertex") {
  InsertionBench bench;
  bench.add_straight_path(0.020);
  bench.be_in_path(0);
  bench.put_needle(on_line(0.020));
  bench.locate();
  const auto add = [&](int needle, RowRole role, int vertex, const Vector3& n, const Law& law, double force) {
    Row row;
    row.needle = needle, row.role = role, row.index = vertex, row.n = n;
    CHECK(bench.rows.add(row, law, force));
  };
  const Law cut{LawKind::unilateral, 0.2};
  add(0, RowRole::cutting, -1, Vector3::UnitZ(), cut, 0.2);
  add(0, RowRole::tip_lateral, -1, Vector3::UnitX(), {}, 0.03);
  add(0, RowRole::lateral, 1, Vector3::UnitY(), {}, -0.04);
  add(0, RowRole::friction, 1, -Vector3::UnitZ(), {LawKind::friction, 0.01}, -0.01);
  add(0, RowRole::friction, 2, -Vector3::UnitZ(), {LawKind::friction, 0.01}, -0.005);
  add(1, RowRole::cutting, -1, Vector3::UnitX(), cut, 5);  // of another needle
  const InsertionForces forces = read_forces(bench.rows, 0, bench.scratch);

  CHECK((forces.tip - Vector3(0.03, 0, 0.2)).norm() < 1e-15);
  CHECK((forces.cutting - Vector3(0, 0, 0.2)).norm() < 1e-15);
  CHECK((forces.friction - Vector3(0, 0, 0.015)).norm() < 1e-15);
  CHECK((forces.lateral - Vector3(0.03, -0.04, 0)).norm() < 1e-15);
  const Insertion& next = bench.scratch.next;
  CHECK(bench.scratch.cutting);
  CHECK_FALSE(bench.scratch.puncturing);
  CHECK(next.tip.cutting == 0.2);
  CHECK(next.vertices[1].sliding);
  CHECK_FALSE(next.vertices[2].sliding);
  CHECK(next.vertices[1].traction == doctest::Approx(-0.01 / bench.scratch.located.shaft[1].owned));
}

}  // namespace acus::test
