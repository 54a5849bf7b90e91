// SPDX-License-Identifier: GPL-3.0-or-later
// The dimple under a tip: its limits, its spring's derivatives, and a neo-Hookean body.
#include "server/engine/models/unresolved/dimple.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace acus::test {
namespace {

constexpr double kE = 10e3, kNu = 0.45;  // Pa, -
constexpr double kFine = 1e-9, kInfinite = std::numeric_limits<double>::infinity();

Material gel() {
  Material material;
  material.young_modulus = kE;
  material.poisson_ratio = kNu;
  return material;
}

// All of D: a mesh of infinite elements bears none of it.
double depth(double beta, double d, double f, double f_p = 1) {
  return DimpleSpring(Indented(gel(), beta), kInfinite, d, f_p).depth(f);
}

TEST_CASE("a shallow dimple is that of a punch a little thinner than the needle, a deep one depends on no needle") {
  const double d = 1e-3, punch = (1 - kNu * kNu) / (2 * kE * 0.86 * d / 2);
  CHECK(depth(2.1, d, 1e-6) == doctest::Approx(1e-6 * punch).epsilon(1e-6).scale(0));
  CHECK(depth(0, d, 3.0) == doctest::Approx(3 * punch).epsilon(1e-12).scale(0));
  for (const double needle : {0.5e-3, 1e-3, 2e-3})
    CHECK(depth(2.1, needle, 5.0) == doctest::Approx(std::sqrt(5 / (2.1 * kE))).epsilon(2e-3).scale(0));
}

TEST_CASE("on a border both sides bear: a disc inside a body, shallow, and the sum of both, deep") {
  Material stiff = gel();
  stiff.young_modulus = 3 * kE;
  const double d = 1e-3;
  const auto border = [&](const Material& behind, double f) {
    Indented sides(gel(), 2.1);
    sides += Indented(behind, 2.1);
    return DimpleSpring(sides, kInfinite, d, 1).depth(f);
  };
  // A rigid disc in one material [Collins 1962].
  const double shear = kE / (2 * (1 + kNu)), r = 0.86 * d / 2, f = 1e-6;
  CHECK(border(gel(), f) == doctest::Approx(f * (3 - 4 * kNu) / (32 * shear * r * (1 - kNu))).epsilon(0.01).scale(0));
  CHECK(border(stiff, 5) == doctest::Approx(std::sqrt(5 / (2.1 * 4 * kE))).epsilon(0.01).scale(0));
  CHECK(border(stiff, 5) < border(gel(), 5));
}

TEST_CASE("a dimple's depth does not depend on the puncture force") {
  for (const double f : {0.01, 0.1, 0.3}) CHECK(depth(1, 1e-3, f, 0.3) == depth(1, 1e-3, f, 6));
}

// tests/references/indentation.py: depth (mm) and force (N) of needles of 1 and 2 mm on a neo-Hookean body.
TEST_CASE("beta = 0.2 is a neo-Hookean body to 10 %") {
  struct Measured {
    double d, depth, force;
  };
  for (const auto& [d, deep, force] : {Measured{1, 1.04, 0.0110},
                                       {1, 2, 0.0209},
                                       {1, 2.72, 0.0300},
                                       {2, 1.04, 0.0229},
                                       {2, 2, 0.0427},
                                       {2, 3.68, 0.0780}})
    CHECK(depth(0.2, 1e-3 * d, force) == doctest::Approx(1e-3 * deep).epsilon(0.1).scale(0));
}

TEST_CASE("the spring's compliance and energy are those of its depth") {
  for (const double beta : {0.0, 0.2, 2.1, 10.0})
    for (const double edge : {kFine, 2e-3, 20e-3})
      for (const double f : {1e-3, 0.03, 0.4, 0.9}) {
        const DimpleSpring spring(Indented(gel(), beta), edge, 1e-3, 1);
        const double step = 1e-4 * f;
        const double compliance = (spring.depth(f + step) - spring.depth(f - step)) / (2 * step);
        CHECK(spring.compliance(f) == doctest::Approx(compliance).epsilon(1e-6).scale(0));
        const double power = (spring.energy(f + step) - spring.energy(f - step)) / (2 * step);
        CHECK(power == doctest::Approx(f * compliance).epsilon(1e-6).scale(0));
      }
}

TEST_CASE("the spring yields to every force up to the puncture, whatever the mesh") {
  for (const double beta : {0.0, 0.2, 2.1, 100.0})
    for (const double f_p : {1e-3, 1.0, 1e3})
      for (const double edge : {kFine, 5e-3, 1.0}) {
        const DimpleSpring spring(Indented(gel(), beta), edge, 1e-3, f_p);
        CHECK(spring.compliance(0) > 0);
        CHECK(spring.compliance(f_p) >= 0);
        CHECK(spring.energy(f_p) >= 0);
      }
}

TEST_CASE("the force at a depth is that at which the dimple has it") {
  for (const double beta : {0.0, 0.2, 2.1, 10.0})
    for (const double f : {1e-4, 0.01, 0.3, 5.0})
      CHECK(dimple_force(Indented(gel(), beta), 1e-3, depth(beta, 1e-3, f)) ==
            doctest::Approx(f).epsilon(1e-9).scale(0));
}

TEST_CASE("the disc in the mesh is that of f_p up to what elements bear, and follows the tip where f_p has no end") {
  const double edge = 5e-3, d = 1e-3;
  for (const double beta : {0.2, 2.1}) {
    const Indented tissue(gel(), beta);
    const double f_e = 3 * tissue.stiffness * edge * edge;
    const auto load = [&](double f_p, double f, double s) { return disc_load(tissue, edge, d, f_p, f, s); };
    for (const double f_p : {0.0, 0.01 * f_e, 0.5 * f_e, f_e}) CHECK(load(f_p, 0.3 * f_p, 0.01) == f_p);
    for (const double f : {0.0, 0.1 * f_e, 2 * f_e})
      for (const double s : {0.0, 1e-3, 8e-3}) {
        const double follows = load(kInfinite, f, s);
        CHECK(follows >= std::max(f, dimple_force(tissue, d, 2 * s)));
        CHECK(follows <= std::max({f, dimple_force(tissue, d, 4 * s), 0.1 * f_e}));
        CHECK(load(20 * f_e + 1e4, f, s) == follows);
        CHECK(load(1.0001 * f_e, f, s) == doctest::Approx(f_e).epsilon(1e-3).scale(0));
      }
  }
}

TEST_CASE("the mesh bears a contact over twice the dimple, whose radius is that of the depth at f_p") {
  for (const double f_p : {0.3, 1.0, 3.0}) {
    const double radius = dimple_radius(Indented(gel(), 2.1), 1e-3, f_p);
    CHECK(contact_radius(Indented(gel(), 2.1), 1e-3, f_p) == 2 * radius);
    CHECK(radius == doctest::Approx(depth(2.1, 1e-3, f_p)).epsilon(0.12).scale(0));
    CHECK(dimple_radius(Indented(gel(), 0.2), 1e-3, f_p) == radius);
  }
}

}  // namespace
}  // namespace acus::test
