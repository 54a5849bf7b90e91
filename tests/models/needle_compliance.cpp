// SPDX-License-Identifier: GPL-3.0-or-later
// The compliance that rows see of a needle is H A⁻¹ Hᵀ of the dense matrix, wherever they stand and in any order.
#include "server/engine/models/needle/needle_compliance.h"

#include <doctest/doctest.h>

#include "server/engine/math/random.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

struct Chain {
  BlockTridiagonal blocks;
  MatrixX dense;
};

Chain random_chain(int beams, Random& random) {
  Chain chain;
  chain.blocks.resize(beams);
  chain.dense.setZero(6 * beams, 6 * beams);
  for (int i = 0; i < beams; ++i) {
    const Matrix6 g = random.matrix(6, 6);
    chain.blocks.diagonal[static_cast<std::size_t>(i)] = g * g.transpose() + 8 * Matrix6::Identity();
    chain.dense.block<6, 6>(6 * i, 6 * i) = chain.blocks.diagonal[static_cast<std::size_t>(i)];
    if (i == 0) continue;
    const Matrix6 lower = random.matrix(6, 6);
    chain.blocks.lower[static_cast<std::size_t>(i - 1)] = lower;
    chain.dense.block<6, 6>(6 * i, 6 * (i - 1)) = lower;
    chain.dense.block<6, 6>(6 * (i - 1), 6 * i) = lower.transpose();
  }
  REQUIRE(chain.blocks.factorize());
  return chain;
}

// One column per row; the first node is held and has no unknowns.
MatrixX generalised_forces(const std::vector<BeamRow>& rows, int beams) {
  MatrixX h = MatrixX::Zero(6 * beams, static_cast<Eigen::Index>(rows.size()));
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const int beam = rows[r].beam;
    const auto column = static_cast<Eigen::Index>(r);
    if (beam > 0) h.block<6, 1>(6 * (beam - 1), column) = rows[r].force.head<6>();
    h.block<6, 1>(6 * beam, column) = rows[r].force.tail<6>();
  }
  return h;
}

TEST_CASE("the compliance of rows is that of the dense inverse") {
  Random random(1);
  for (const int beams : {1, 2, 5, 12}) {
    const Chain chain = random_chain(beams, random);
    NeedleCompliance compliance(beams, 20);
    for (const int count : {0, 1, 7, 20}) {
      std::vector<BeamRow> rows;
      std::vector<int> places;
      for (int r = 0; r < count; ++r) {
        rows.push_back({random.index(beams), random.matrix(12, 1)});
        places.push_back((7 * r + 3) % 20);  // all different
      }
      const MatrixX h = generalised_forces(rows, beams), expected = h.transpose() * test::solve_dense(chain.dense, h);
      MatrixX W = MatrixX::Constant(20, 20, 0.5);
      compliance.add_to(chain.blocks, rows, places, W);
      double worst = 0;
      for (int a = 0; a < count; ++a)
        for (int b = 0; b < count; ++b) {
          const int p = places[static_cast<std::size_t>(a)], q = places[static_cast<std::size_t>(b)];
          worst = std::max(worst, std::abs(W(std::max(p, q), std::min(p, q)) - 0.5 - expected(a, b)));
        }
      CHECK(worst < 1e-13 * (1 + (count == 0 ? 0 : expected.cwiseAbs().maxCoeff())));
      CHECK((W.array() == 0.5).count() >= 400 - count * (count + 1) / 2);  // nothing else is touched
    }
  }
}

TEST_CASE("rows on the held end alone see nothing") {
  Random random(2);
  const Chain chain = random_chain(3, random);
  Vector12 force = Vector12::Zero();
  force.head<6>() = random.matrix(6, 1);
  NeedleCompliance compliance(3, 1);
  MatrixX W = MatrixX::Zero(1, 1);
  const BeamRow row{0, force};
  const int place = 0;
  compliance.add_to(chain.blocks, {&row, 1}, {&place, 1}, W);
  CHECK(W(0, 0) == 0);
}

}  // namespace
}  // namespace acus
