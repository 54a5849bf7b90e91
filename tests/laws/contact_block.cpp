// SPDX-License-Identifier: GPL-3.0-or-later
// A contact with friction is solved to the graphs of its laws, however strongly normal and friction are coupled.
#include "server/engine/laws/contact_block.h"

#include <doctest/doctest.h>

#include <limits>

#include "server/engine/math/random.h"

namespace acus {
namespace {

using Vector2 = Eigen::Vector2d;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Soft sideways, stiff along the normal, coupled: positive definite, with W_nt up to sqrt(W_nn W_tt).
Matrix3 random_block(Random& random) {
  Matrix3 root;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) root(i, k) = random.uniform(-1, 1);
  const Vector3 scale(random.uniform(0.01, 1), random.uniform(0.1, 10), random.uniform(0.1, 10));
  const Matrix3 scaled = scale.asDiagonal() * root;
  return scaled * scaled.transpose() + 1e-4 * Matrix3(scale.cwiseAbs2().asDiagonal());
}

void check_laws(const ContactLaw& law, const Vector3& lambda, const Vector3& delta, double scale) {
  const double slack = 1e-9 * scale, force_slack = 1e-9 * (1 + lambda.norm());
  CHECK(lambda[0] >= 0);
  CHECK(lambda[0] <= law.limit);
  if (lambda[0] == 0) CHECK(delta[0] >= -slack);
  if (lambda[0] == law.limit) CHECK(delta[0] <= slack);
  if (lambda[0] > 0 && lambda[0] < law.limit) CHECK(std::abs(delta[0]) <= slack);

  const Vector2 t = lambda.tail<2>(), slip = delta.tail<2>();
  const double radius = law.cohesion + law.friction * lambda[0];
  CHECK(t.norm() <= radius + force_slack);
  if (t.norm() < radius - force_slack) {
    CHECK(slip.norm() <= slack);
  } else if (radius > 0) {  // opposed to the slip
    CHECK((t.norm() * slip + slip.norm() * t).norm() <= 2 * slack * t.norm());
  }
}

TEST_CASE("a contact's forces lie on the graphs of its laws") {
  Random random(1);
  int separate = 0, sticking = 0, sliding = 0, capped = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const Matrix3 W = random_block(random);
    const Vector3 bar(random.uniform(-1, 0.3), random.uniform(-3, 3), random.uniform(-3, 3));
    const ContactLaw law{trial % 3 == 0 ? random.uniform(0.1, 5) : kInfinite, trial % 5 == 0 ? 0 : random.uniform(0, 2),
                         trial % 2 == 0 ? 0 : random.uniform(0, 1)};
    const Vector3 lambda = contact_force(law, W, bar);
    const Vector3 delta = W * lambda + bar;
    CAPTURE(trial);
    check_laws(law, lambda, delta, bar.norm() + (W * lambda).norm());
    const double rim = law.cohesion + law.friction * lambda[0];
    if (lambda[0] == 0)
      ++separate;
    else if (lambda[0] == law.limit)
      ++capped;
    else if (lambda.tail<2>().norm() < rim * (1 - 1e-9))
      ++sticking;
    else
      ++sliding;
  }
  // All four happen.
  CHECK(separate > 500);
  CHECK(sticking > 500);
  CHECK(sliding > 500);
  CHECK(capped > 500);
}

TEST_CASE("a contact without friction or cohesion has its normal force alone") {
  const Matrix3 W = Vector3(0.5, 2, 2).asDiagonal();
  CHECK(contact_force({kInfinite, 0, 0}, W, {-1, 3, 4}) == Vector3(2, 0, 0));
  CHECK(contact_force({1.5, 0, 0}, W, {-1, 3, 4}) == Vector3(1.5, 0, 0));
  CHECK(contact_force({kInfinite, 0, 0}, W, {1, 3, 4}) == Vector3(0, 0, 0));
}

TEST_CASE("a contact slides against its motion at mu times the normal force") {
  const Matrix3 W = Vector3(0.5, 2, 2).asDiagonal();
  const Vector3 lambda = contact_force({kInfinite, 0.5, 0}, W, {-1, 3, 4});
  CHECK(lambda[0] == doctest::Approx(2));
  CHECK(lambda[1] == doctest::Approx(-0.6));
  CHECK(lambda[2] == doctest::Approx(-0.8));
}

}  // namespace
}  // namespace acus
