// SPDX-License-Identifier: GPL-3.0-or-later
// The corridor's columns against the dense inverse, and how its slots are given away.
#include "server/engine/models/tissue/corridor.h"

#include <doctest/doctest.h>

#include "server/engine/math/random.h"
#include "tests/models/bench_tissue.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

struct Bench {
  TetrahedralMesh mesh = make_box_mesh({0.1, 0.1, 0.1}, {3, 3, 3});
  TissueModel model = bench_tissue(mesh, undamped_material(), [](const Vector3& p) { return p.z() < -0.049; });
  SparseCholesky factor;
  MatrixX inverse;

  Bench() {
    const MatrixFactors factors{.mass = 1e4, .stiffness = 1};
    Matrix3X forces;
    SparseMatrix lower;
    TissueAssembler(model).assemble(mesh.nodes, rotations_at(model, mesh.nodes, forces), Tangent::rest, factors, lower);
    factor.analyze(lower, 3);
    REQUIRE(factor.factorize(lower));
    factor.keep(Precision::double_precision);
    inverse = test::inverse(dense_matrix(model, mesh.nodes, Tangent::rest, factors));
  }

  int nodes() const { return static_cast<int>(model.free_nodes.size()); }

  void check_gram(const Corridor& corridor) const {
    for (int a = 0; a < corridor.used(); ++a)
      for (int b = 0; b < corridor.used(); ++b) {
        const Matrix3 expected = inverse.block<3, 3>(3 * corridor.node(a), 3 * corridor.node(b));
        CHECK((corridor.gram().block<3, 3>(3 * a, 3 * b) - expected).norm() < 1e-12 * inverse.norm());
      }
  }
};

TEST_CASE("the Gram matrix is the block of the inverse, also after slots were given away") {
  const Bench bench;
  Corridor corridor(bench.factor, 6);
  for (const int node : {5, 40, 0, bench.nodes() - 1, 17, 23}) CHECK(corridor.slot(node) >= 0);
  CHECK(corridor.used() == 6);
  bench.check_gram(corridor);
  for (const int node : {7, 40, 31}) {
    corridor.begin_use(0);
    CHECK(corridor.slot(node) >= 0);
    bench.check_gram(corridor);
  }
}

TEST_CASE("the node unused for longest makes room") {
  const Bench bench;
  Corridor corridor(bench.factor, 3);
  const auto holds = [&](int node) {
    for (int s = 0; s < corridor.used(); ++s)
      if (corridor.node(s) == node) return true;
    return false;
  };
  for (const int node : {1, 2, 3, 1}) {
    corridor.begin_use(0);
    corridor.slot(node);
  }
  corridor.begin_use(0);
  corridor.slot(4);
  CHECK_FALSE(holds(2));
  CHECK(holds(1));
  CHECK(holds(3));
  CHECK(holds(4));
}

TEST_CASE("a node keeps its slot; a full corridor says no until the next use") {
  const Bench bench;
  Corridor corridor(bench.factor, 2);
  const int slot = corridor.slot(8);
  CHECK(corridor.slot(9) >= 0);
  CHECK(corridor.slot(8) == slot);
  CHECK(corridor.slot(10) == -1);
  bench.check_gram(corridor);
  corridor.begin_use(0);
  CHECK(corridor.slot(10) >= 0);
}

TEST_CASE("columns made ahead, by and by, are those made at once") {
  const Bench bench;
  Corridor corridor(bench.factor, 5), at_once(bench.factor, 5);
  const auto make = [&](int node) {
    int uses = 0;
    do corridor.begin_use(300), ++uses;
    while (corridor.make_ahead(node));
    return uses;
  };
  corridor.slot(3);
  CHECK(make(40) > 3);
  CHECK(make(40) == 1);
  // One that is asked for before it is done, and others that are asked for meanwhile.
  corridor.begin_use(300);
  CHECK(corridor.make_ahead(17));
  CHECK(corridor.slot(7) >= 0);
  CHECK(corridor.slot(17) >= 0);
  // One that is left behind, and finished before the next; slots that are asked for when it is multiplied.
  corridor.begin_use(300);
  CHECK(corridor.make_ahead(29));
  CHECK(make(40) > 3);
  CHECK(corridor.used() == 5);
  for (const int node : {3, 40, 17, 7, 29}) at_once.slot(node);
  CHECK(corridor.gram() == at_once.gram());
  bench.check_gram(corridor);
}

TEST_CASE("what is made ahead gives way where there is no other room") {
  const Bench bench;
  Corridor corridor(bench.factor, 2);
  corridor.begin_use(300);
  CHECK(corridor.make_ahead(5));
  CHECK(corridor.slot(8) >= 0);
  CHECK(corridor.slot(9) >= 0);
  CHECK_FALSE(corridor.make_ahead(5));
  corridor.begin_use(300);
  CHECK(corridor.slot(9) >= 0);
  CHECK(corridor.make_ahead(5));
  CHECK(corridor.slot(8) >= 0);
  bench.check_gram(corridor);
}

TEST_CASE("cleared, the corridor forgets and fills again") {
  const Bench bench;
  Corridor corridor(bench.factor, 2);
  corridor.slot(8);
  corridor.clear();
  CHECK(corridor.used() == 0);
  CHECK(corridor.slot(9) == 0);
  CHECK(corridor.slot(8) == 1);
  bench.check_gram(corridor);
}

TEST_CASE("columns give free displacements and take forces") {
  const Bench bench;
  Corridor corridor(bench.factor, 3);
  Random random(1);
  const VectorX r = random.matrix(bench.factor.size(), 1);
  VectorX y(r.size());
  for (int i = 0; i < bench.factor.size(); ++i) y[bench.factor.position(i)] = r[i];
  MatrixX panel_rows = bench.factor.make_panel_rows();
  bench.factor.forward(y, panel_rows);

  const Vector3 force = random.vector();
  VectorX loaded = r;
  loaded.segment<3>(3 * 21) += force;
  const int slot = corridor.slot(21);
  CHECK((corridor.free_displacement(slot, y) - (bench.inverse * r).segment<3>(3 * 21)).norm() <
        1e-12 * bench.inverse.norm());

  corridor.add_force(slot, force, y);
  bench.factor.backward(y, panel_rows);
  const VectorX expected = bench.inverse * loaded;
  double error = 0;
  for (int i = 0; i < bench.factor.size(); ++i)
    error = std::max(error, std::abs(y[bench.factor.position(i)] - expected[i]));
  CHECK(error < 1e-12 * expected.norm());
}

}  // namespace
}  // namespace acus
