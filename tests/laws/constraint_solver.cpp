// SPDX-License-Identifier: GPL-3.0-or-later
// Both methods: against an oracle that tries every combination of branches; contacts, residual, bounds, determinism.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

#include "tests/laws/law_problems.h"

namespace acus {
namespace {

bool same_bits(const VectorX& a, const VectorX& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

TEST_CASE("both methods find the one point where all graphs meet their lines") {
  Random random(1);
  for (int repeat = 0; repeat < 1000; ++repeat) {
    Problem p;
    const int n = 1 + random.index(6);
    p.W = random_compliance(n, random);
    p.delta_free = random.matrix(n, 1);
    for (int i = 0; i < n; ++i) p.laws.push_back(random_law(random));
    const std::optional<VectorX> oracle = enumerate(p);
    REQUIRE(oracle);
    for (const LawMethod method : kBothMethods) {
      const Answer answer = solve(p, method);
      CAPTURE(repeat);
      CHECK(answer.result.method == method);
      CHECK(answer.result.residual < 1e-10 * std::max(1.0, oracle->cwiseAbs().maxCoeff()));
      CHECK((answer.lambda - *oracle).norm() < 1e-9 * (1 + oracle->norm()));
    }
  }
}

TEST_CASE("disk friction obeys Coulomb's cone") {
  for (const LawMethod method : kBothMethods) {
    Random random(2);
    int sticking = 0, sliding = 0;
    for (int repeat = 0; repeat < 200; ++repeat) {
      Problem p = contact_problem(random, 0.3);
      p.delta_free[0] = -std::abs(p.delta_free[0]);
      if (repeat % 2 == 0) p.delta_free.tail<2>() *= 0.01;
      const Answer a = solve(p, method);
      REQUIRE(a.result.converged);
      CHECK(off_graphs(p, a) < 1e-10);
      ++(a.lambda.tail<2>().norm() < 0.3 * a.lambda[0] - 1e-6 ? sticking : sliding);
    }
    CHECK(sticking > 10);
    CHECK(sliding > 10);
  }
}

TEST_CASE("disk friction does not depend on the axes across the normal") {
  Random random(3);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const Problem p = contact_problem(random, 0.3);
    Matrix3 turn = Matrix3::Identity();
    turn.bottomRightCorner<2, 2>() = Eigen::Rotation2Dd(random.uniform(-3, 3)).toRotationMatrix();
    Problem turned = p;
    turned.W = turn * p.W * turn.transpose();
    turned.delta_free = turn * p.delta_free;
    for (const LawMethod method : kBothMethods)
      CHECK((solve(turned, method).lambda - turn * solve(p, method).lambda).norm() < 1e-9);
  }
}

TEST_CASE("disks keep to their normal row when bilateral rows stand in between") {
  Random random(4);
  Problem p;
  p.W = random_compliance(5, random);
  p.delta_free = VectorX(5);
  p.delta_free << 0.1, -1, 0.2, 0.4, -0.3;
  p.laws = {{LawKind::bilateral},
            {LawKind::unilateral, 3},
            {LawKind::bilateral},
            {LawKind::disk_first, 0.2, 0, 1},
            {LawKind::disk_second, 0.2, 0, 1}};
  for (const LawMethod method : kBothMethods) {
    const Answer a = solve(p, method, {.tolerance = 1e-8});
    REQUIRE(a.result.converged);
    CHECK(a.lambda[1] > 0);
    CHECK(a.lambda.tail<2>().norm() == doctest::Approx(0.2 * a.lambda[1]).epsilon(1e-6));
    CHECK(std::abs(a.delta[0]) < 1e-9);
    CHECK(std::abs(a.delta[2]) < 1e-9);
  }
}

// Rows 0 to 3 twice over: W has rank 4 of 8.
Problem doubled_problem(Random& random) {
  const MatrixX w = random_compliance(4, random);
  const VectorX free = random.matrix(4, 1);
  Problem p;
  p.W.resize(8, 8);
  p.W << w, w, w, w;
  p.delta_free.resize(8);
  p.delta_free << free, free;
  for (int copy = 0; copy < 2; ++copy)
    for (const Law& law : {Law{LawKind::bilateral}, Law{LawKind::unilateral, 2.0}, Law{LawKind::friction, 0.5},
                           Law{.kind = LawKind::bilateral}})
      p.laws.push_back(law);
  return p;
}

TEST_CASE("rows that say the same twice stay bounded and share the force") {
  Random random(5);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const Problem p = doubled_problem(random);
    for (const LawMethod method : kBothMethods) {
      const Answer a = solve(p, method, {1000, 1e-6});
      REQUIRE(a.lambda.allFinite());
      CHECK(a.lambda.cwiseAbs().maxCoeff() < 10);
      CHECK(a.result.converged);
      CHECK(std::abs(a.delta[0]) < 1e-9);
      CHECK(std::abs(a.delta[3]) < 1e-9);
      CHECK(a.lambda[0] == doctest::Approx(a.lambda[4]).epsilon(4e-3).scale(0));
    }
  }
}

TEST_CASE("a capped or frictional row along a bilateral one stays bounded") {
  Random random(6);
  for (const Law& law : {Law{LawKind::unilateral, 2.0}, Law{LawKind::unilateral, kInfinite},
                         Law{LawKind::friction, 0.5}, Law{LawKind::friction, 0.5, 3.0}}) {
    const MatrixX w = random_compliance(2, random);
    Problem p;
    p.W.resize(3, 3);
    p.W << w, w.col(1), w.row(1), w(1, 1);
    p.delta_free = Vector3(0.3, -0.2, -0.2);
    p.laws = {{LawKind::bilateral}, {LawKind::bilateral}, law};
    for (const LawMethod method : kBothMethods) {
      const Answer a = solve(p, method, {1000, 1e-6});
      CHECK(a.lambda.allFinite());
      CHECK(a.lambda.cwiseAbs().maxCoeff() < 10);
      CHECK(std::abs(a.delta[0]) < 1e-9);
      CHECK(std::abs(a.delta[1]) < 1e-9);
    }
  }
}

TEST_CASE("two contacts in the same place carry together what one would") {
  Problem p;
  p.W = MatrixX::Constant(2, 2, 0.5);
  p.delta_free = Eigen::Vector2d(-1, -1);
  p.laws = {{LawKind::unilateral, kInfinite}, {LawKind::unilateral, kInfinite}};
  for (const LawMethod method : kBothMethods) {
    const Answer a = solve(p, method);
    CHECK(a.result.converged);
    CHECK(a.lambda.sum() == doctest::Approx(2));
  }
}

TEST_CASE("displacements and residual are those of the forces returned, converged or not") {
  Random random(7);
  for (const int max_steps : {0, 1, 3, 10000}) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      Problem p = contact_problem(random, 0.3);
      p.laws.insert(p.laws.end(), {{LawKind::bilateral}, {LawKind::friction, 0.2}, {LawKind::unilateral, 1.0}});
      p.W = random_compliance(6, random);
      p.delta_free = random.matrix(6, 1);
      Answer a = solve(p, LawMethod::gauss_seidel, {max_steps, 1e-10}, random.matrix(6, 1));
      CHECK((a.delta - p.W * a.lambda - p.delta_free).norm() < 1e-12);
      VectorX scale(6);
      law_scales(p.W, p.laws, {scale.data(), 6});
      const LawSystem system{p.W, p.laws, {p.delta_free.data(), 6}, {scale.data(), 6}};
      CHECK(a.result.residual == law_residual(system, {{a.lambda.data(), 6}, {a.delta.data(), 6}}));
      CHECK(a.result.converged == (a.result.residual <= 1e-10));
      CHECK(a.result.sweeps <= max_steps);
      if (max_steps == 10000) CHECK(a.result.residual < 1e-10);
    }
  }
}

TEST_CASE("a start at the answer needs no sweep") {
  Random random(8);
  const Problem p = contact_problem(random, 0.3);
  const Answer first = solve(p, LawMethod::gauss_seidel, {.tolerance = 1e-12});
  CHECK(solve(p, LawMethod::gauss_seidel, {.tolerance = 1e-9}, first.lambda).result.sweeps == 0);
}

// One contact, whose friction presses it on; `held`: the forces that would hold it.
Problem dragged_contact(double friction, const Vector3& held) {
  Problem p;
  p.W = Matrix3{{1, -0.9, 0}, {-0.9, 1, 0}, {0, 0, 1}};
  p.laws = {{LawKind::unilateral, kInfinity},
            {.kind = LawKind::disk_first, .limit = friction, .normal_row = 0},
            {.kind = LawKind::disk_second, .limit = friction, .normal_row = 0}};
  p.delta_free = -p.W * held;
  return p;
}

TEST_CASE("of two answers, a contact held by friction and an open one, it is the one that the forces come from") {
  const Vector3 held(1, 1.2, 0);
  const Problem p = dragged_contact(5, held);
  REQUIRE(p.delta_free[0] > 0);  // without friction it opens
  for (const LawMethod method : kBothMethods) {
    CHECK((solve(p, method, {}, Vector3(0.97, 1.15, 0.02)).lambda - held).norm() < 1e-9);
    CHECK(solve(p, method).lambda.isZero(0));
  }
}

TEST_CASE("a pressed contact opens where friction cannot hold it") {
  const Problem p = dragged_contact(0.5, {1, 1.2, 0});
  for (const LawMethod method : kBothMethods) {
    const Answer a = solve(p, method, {}, Vector3(0.97, 1.15, 0.02));
    CHECK(a.lambda.isZero(0));
    CHECK(a.result.converged);
  }
}

TEST_CASE("the same problem gives the same bits, in a solver that has seen others") {
  Random random(9);
  const Problem p = doubled_problem(random), other = contact_problem(random, 0.5);
  for (const LawMethod method : kBothMethods) {
    ConstraintSolver used(12);
    const VectorX first = solve(used, p, method, {200, 1e-9}).lambda;
    solve(used, other, method);
    CHECK(same_bits(first, solve(used, p, method, {200, 1e-9}).lambda));
    CHECK(same_bits(first, solve(p, method, {200, 1e-9}).lambda));
  }
}

TEST_CASE("W may be larger than the rows in use, and there may be none") {
  Random random(10);
  Problem p = contact_problem(random, 0.3);
  for (const LawMethod method : kBothMethods) {
    const Answer tight = solve(p, method);
    Problem padded = p;
    padded.W = MatrixX::Constant(9, 9, 1e9);
    padded.W.topLeftCorner(3, 3) = p.W;
    CHECK(same_bits(solve(padded, method).lambda, tight.lambda));
    const Answer none = solve(Problem{p.W, {}, {}}, method);
    CHECK(none.result.converged);
    CHECK(none.result.sweeps == 0);
  }
}

TEST_CASE("numbers that are not finite end in no forces and no claim") {
  Random random(11);
  Problem p = contact_problem(random, 0.3);
  p.laws.push_back({LawKind::bilateral});
  p.W = random_compliance(4, random);
  p.W(3, 3) = std::nan("");
  p.delta_free = random.matrix(4, 1);
  for (const LawMethod method : kBothMethods) {
    const Answer a = solve(p, method, {100, 1e-9});
    CHECK(a.lambda.isZero(0));
    CHECK_FALSE(a.result.converged);
  }
}

TEST_CASE("what is not a number takes no step and leaves no force") {
  Random random(20);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Law& law : {Law{LawKind::bilateral}, Law{LawKind::unilateral, 2.0}, Law{LawKind::friction, 0.5},
                         Law{LawKind::friction, 0.5, 3.0}}) {
    Problem p;
    p.W = random_compliance(4, random);
    p.delta_free = random.matrix(4, 1);
    p.laws = {{LawKind::bilateral}, law, {LawKind::unilateral, 1.0}, {LawKind::friction, 1.0}};
    p.delta_free[1] = nan;
    for (const LawMethod method : kBothMethods) {
      const Answer a = solve(p, method);
      CHECK_FALSE(a.result.converged);
      CHECK(a.result.method == method);
      CHECK(a.result.sweeps + a.result.steps.picks + a.result.steps.iterations == 0);
      CHECK(a.lambda == VectorX::Zero(4));
    }
  }
}

TEST_CASE("a compliance that is not a number ends the sweeps at once") {
  Random random(21);
  Problem p;
  p.W = random_compliance(3, random);
  p.W(2, 2) = std::numeric_limits<double>::quiet_NaN();
  p.delta_free = -random.matrix(3, 1).cwiseAbs();
  p.laws = {{LawKind::bilateral}, {LawKind::unilateral, 2.0}, {LawKind::friction, 0.5}};
  for (const LawMethod method : kBothMethods) {
    const Answer a = solve(p, method);
    CHECK_FALSE(a.result.converged);
    CHECK(a.result.sweeps <= 1);
    CHECK(a.lambda.allFinite());
  }
}

}  // namespace
}  // namespace acus
