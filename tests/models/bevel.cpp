// SPDX-License-Identifier: GPL-3.0-or-later
// models/unresolved/bevel.h against its equation, solved by finite elements, and its limits.
#include "server/engine/models/unresolved/bevel.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "tests/support/dense.h"

namespace acus {
namespace {

constexpr double kUntorn = std::numeric_limits<double>::infinity();

// lambda (1/m) of a bevel of 90 degrees that meets no force: its curvature is d lambda².
double decay(double d, double bending, const Material& tissue) {
  const Bevel steep{d, bending, std::numbers::pi / 2, d / 2};
  return std::sqrt(bevel_path(steep, {tissue, 0, kUntorn}).curvature / d);
}

// The curvature (1/m) of the cut by Hermite beams on the foundation. Unknowns: the deflections and slopes of the nodes,
// from the edge backwards, in a frame whose x axis is tangent to the cut at the edge, and the curvature.
double beams_on_foundation(const Bevel& bevel, double lambda, double cutting_force) {
  constexpr double kLength = 8;  // over 1/lambda
  const double e = bevel.offset, EI = bevel.bending, k = 4 * EI * std::pow(lambda, 4);
  const double face_length = bevel.diameter / std::tan(bevel.face);
  const double h = face_length / std::ceil(50 * lambda * face_length);  // the face ends at a node
  const int beams = static_cast<int>(kLength / lambda / h), n = 2 * (beams + 1);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n + 1, n + 1);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n + 1);
  Eigen::Matrix4d stiffness, mass;
  stiffness << 12, 6 * h, -12, 6 * h, 6 * h, 4 * h * h, -6 * h, 2 * h * h, -12, -6 * h, 12, -6 * h, 6 * h, 2 * h * h,
      -6 * h, 4 * h * h;
  mass << 156, 22 * h, 54, -13 * h, 22 * h, 4 * h * h, 13 * h, -3 * h * h, 54, 13 * h, 156, -22 * h, -13 * h,
      -3 * h * h, -22 * h, 4 * h * h;
  const Eigen::Matrix4d bend = EI / (h * h * h) * stiffness, hold = k * h / 420 * mass;
  const auto arc = [](double x) { return Eigen::Vector2d(-x * x / 2, -x); };  // of the cut, per curvature
  for (int i = 0; i < beams; ++i) {
    const double x = i * h, slope = x < face_length - h / 2 ? -e / face_length : 0;
    const double height = slope == 0 ? 0 : e + slope * x;  // of the section's middle, at the node
    a.block<4, 4>(2 * i, 2 * i) += bend + hold;
    Eigen::Vector4d cut, section;
    cut << arc(x), arc(x + h);
    section << height, slope, height + slope * h, slope;
    a.block<4, 1>(2 * i, n) -= hold * cut;
    b.segment<4>(2 * i) += hold * section;
  }
  a(n - 1, n) += EI;         // the far end has the curvature of the cut
  a(0, 1) += cutting_force;  // EI w''' = -f_c w'
  b[1] += cutting_force * e;
  a(n, 0) = 1;  // the edge is on the cut
  b[n] = e;
  return test::solve_dense(a, b)(n, 0);
}

TEST_CASE("a bevel's curvature is that of a beam on a foundation whose edge cuts where it goes") {
  std::mt19937 random(3);
  const auto between = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution(0.0, 1.0)(random));
  };
  for (const double u : {0.03, 0.1, 0.3, 0.8, 1.5, 2.5})
    for (const double q : {0.0, 0.1, 0.5, 2.0}) {
      CAPTURE(u);
      CAPTURE(q);
      const double d = between(0.3e-3, 3e-3), bending = between(5e9, 200e9) * std::numbers::pi / 64 * std::pow(d, 4);
      const Material tissue{.young_modulus = between(2e3, 300e3), .poisson_ratio = between(0.2, 0.49)};
      const double lambda = decay(d, bending, tissue);
      const Bevel bevel{d, bending, std::atan(lambda * d / u), between(0.1, 1) * d / 2};
      const double f_c = q * 2 * bending * lambda * lambda;
      const double expected = beams_on_foundation(bevel, lambda, f_c);
      const double found = bevel_path(bevel, {tissue, f_c, kUntorn}).curvature;
      CHECK(found == doctest::Approx(expected).epsilon(1e-3).scale(lambda * lambda * bevel.offset));
    }
}

TEST_CASE("a bevel's path: what one would expect") {
  const Bevel bevel{1e-3, 3e-3, 0.2, 0.5e-3};
  const Material tissue{.young_modulus = 20e3, .poisson_ratio = 0.45};
  const auto path = [&](const Bevel& b, double E, double f_c = 0.1, double strength = kUntorn) {
    Material m = tissue;
    m.young_modulus = E;
    return bevel_path(b, {m, f_c, strength});
  };
  const double curvature = path(bevel, 20e3).curvature;
  // Stiffer tissue, a softer needle: more. About the root of E/EI.
  CHECK(path(bevel, 80e3, 0.2).curvature == doctest::Approx(2 * curvature).epsilon(0.05).scale(0));
  CHECK(path({1e-3, 12e-3, 0.2, 0.5e-3}, 20e3).curvature == doctest::Approx(0.5 * curvature).epsilon(0.07).scale(0));
  // All forces tenfold: the same.
  CHECK(path({1e-3, 3e-2, 0.2, 0.5e-3}, 200e3, 1).curvature == doctest::Approx(curvature).epsilon(1e-12).scale(0));
  // All lengths tenfold: a tenth.
  CHECK(path({1e-2, 3e1, 0.2, 5e-3}, 20e3, 10).curvature == doctest::Approx(curvature / 10).epsilon(1e-12).scale(0));
  CHECK(path({1e-2, 3e1, 0.2, 5e-3}, 20e3, 10).slope ==
        doctest::Approx(path(bevel, 20e3).slope).epsilon(1e-12).scale(0));
  // Half as far off the axis: half of it; on the axis: none.
  CHECK(path({1e-3, 3e-3, 0.2, 0.25e-3}, 20e3).curvature == doctest::Approx(curvature / 2).epsilon(1e-12).scale(0));
  CHECK(path({1e-3, 3e-3, 0.2, 0}, 20e3).curvature == 0);
  // A tougher tissue, a longer bevel: less.
  CHECK(path(bevel, 20e3, 1).curvature < curvature);
  CHECK(path({1e-3, 3e-3, 0.1, 0.5e-3}, 20e3).curvature < curvature);
  // Tissue that tears: in proportion to its strength, none without.
  const double weak = path(bevel, 20e3, 0.1, 1).curvature;
  CHECK(weak < 0.5 * curvature);
  CHECK(path(bevel, 20e3, 0.1, 0.5).curvature == doctest::Approx(weak / 2).epsilon(1e-12).scale(0));
  CHECK(path(bevel, 20e3, 0.1, 1e-9).curvature < 1e-9);
  // Never back, in any extreme.
  for (const double E : {1e-2, 1e3, 1e13})
    for (const double f_c : {0.0, 1.0, 1e6})
      for (const double face : {0.01, 1.5})
        for (const double bending : {1e-12, 1e6}) {
          const BevelPath found = path({1e-3, bending, face, 0.5e-3}, E, f_c);
          CHECK(std::isfinite(found.slope));
          CHECK(found.slope >= 0);
          CHECK(std::isfinite(found.curvature));
        }
}

}  // namespace
}  // namespace acus
