// SPDX-License-Identifier: GPL-3.0-or-later
// The groove under a shaft: its limits and its spring's derivatives.
#include "server/engine/models/unresolved/groove.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace acus::test {
namespace {

constexpr double kE = 10e3, kNu = 0.45;                                  // Pa, -
constexpr double kD = 1e-3, kEdge = 10e-3, kLength = 8e-3;               // m
constexpr double kLine = 2 * (1 - kNu * kNu) / (std::numbers::pi * kE);  // C (m²/N)
constexpr double kMesh = 0.31 * kEdge;                                   // R (m)

GrooveSpring groove(double edge = kEdge, double length = kLength, double held = 0) {
  Material material;
  material.young_modulus = kE;
  material.poisson_ratio = kNu;
  return {material, edge, kD, length, held};
}

TEST_CASE("under a small load a groove is what two line loads differ by") {
  const double q = 1e-4;
  CHECK(groove().depth(q * kLength) == doctest::Approx(kLine * q * std::log(kMesh / (kD / 2))).epsilon(1e-4).scale(0));
}

TEST_CASE("the same load per length makes the same groove, however long the shaft is") {
  CHECK(groove(kEdge, 2e-3).depth(0.05) == doctest::Approx(groove(kEdge, 8e-3).depth(0.2)).epsilon(1e-12).scale(0));
}

TEST_CASE("a groove is never deeper than the mesh's resolution, and deepens with every load") {
  const double most = kLine * 2 * kE * (kMesh - kD / 2);
  CHECK(groove().depth(1e4 * kE * kD * kLength) < 1.02 * most + 1e-3);
  double before = 0;
  for (double f = 1e-4; f < 100; f *= 1.5) {
    CHECK(groove().depth(f) > before);
    CHECK(groove().compliance(f) > 0);
    before = groove().depth(f);
  }
}

TEST_CASE("where fixed nodes bear it, a body ten times as wide gives way besides, under any load") {
  for (const double f : {1e-3, 0.1, 10.0})
    for (const double held : {0.3, 1.0}) {
      const double more = held * kLine * f / kLength * std::log(10);
      CHECK(groove(kEdge, kLength, held).depth(f) - groove().depth(f) == doctest::Approx(more).epsilon(1e-9).scale(0));
    }
}

TEST_CASE("a mesh that has all of it leaves next to nothing") {
  for (const double edge : {0.0, 1e-3}) {
    CHECK(groove(edge).depth(0.1) <= 1.01e-4 * kLine * 0.1 / kLength);
    CHECK(groove(edge).radii(0.1).resolved());
  }
}

TEST_CASE("the compliance and the energy of a groove are those of its depth") {
  for (const double edge : {0.0, 2e-3, 20e-3})
    for (const double f : {1e-3, 0.03, 0.4, 2.0}) {
      const GrooveSpring spring = groove(edge, kLength, f > 0.1 ? 0.5 : 0);
      const double step = 1e-4 * f;
      const double compliance = (spring.depth(f + step) - spring.depth(f - step)) / (2 * step);
      CHECK(spring.compliance(f) == doctest::Approx(compliance).epsilon(1e-6).scale(0));
      const double power = (spring.energy(f + step) - spring.energy(f - step)) / (2 * step);
      CHECK(power == doctest::Approx(f * compliance).epsilon(2e-5).scale(0));
    }
  CHECK(groove().energy(0) == doctest::Approx(0).scale(1e-9));
}

}  // namespace
}  // namespace acus::test
