// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene may leave out: pressure and foundation, from the material.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "server/engine/models/unresolved/local_compliance.h"
#include "tests/tick/bench.h"

namespace acus::test {

TEST_CASE("a pressure that is left out is twice the shear modulus") {
  Region region;
  region.material.young_modulus = 15e3;
  region.material.poisson_ratio = 0.25;
  CHECK(shaft_pressure(region) == doctest::Approx(12e3));
  region.interaction.pressure = 5e3;
  CHECK(shaft_pressure(region) == 5e3);
  region.interaction.pressure = 0;
  CHECK(shaft_pressure(region) == 0);
}

TEST_CASE("the estimated pressure is what rubs on a shaft") {
  Scene scene = block_scene();
  Region& region = scene.tissue.regions[0];
  region.interaction.pressure.reset();
  Bench bench(scene);
  bench.push(0, 0.04, 0.02);
  const double per_metre = std::numbers::pi * 1e-3 * region.interaction.friction_dynamic * shaft_pressure(region);
  const double expected = region.interaction.cutting_force + per_metre * bench.needle().inserted_depth;
  CHECK(bench.resistance() == doctest::Approx(expected).epsilon(2e-5).scale(0));
}

TEST_CASE("the foundation gives way more, the thinner the shaft against the mesh, and not at all in a fine mesh") {
  Material material;
  material.young_modulus = 10e3;
  material.poisson_ratio = 0.4;
  CHECK(foundation_compliance(material, 1e-3, 1e-3) == 0);
  CHECK(foundation_compliance(material, 0.5e-3, 1e-3) == 0);
  double before = 0;
  for (const double edge : {1.1e-3, 2e-3, 5e-3, 10e-3}) {
    const double compliance = foundation_compliance(material, edge, 1e-3);
    CHECK(compliance > before);
    before = compliance;
  }
  // Kelvin's line load in plane strain, by hand: G = 10e3/2.8 Pa.
  const double by_hand = (3 - 1.6) * 2.8 / (8 * std::numbers::pi * 10e3 * 0.6) * std::log(10);
  CHECK(before == doctest::Approx(by_hand).epsilon(1e-9).scale(0));
  material.young_modulus *= 2;
  CHECK(foundation_compliance(material, 10e-3, 1e-3) == doctest::Approx(before / 2).epsilon(1e-9).scale(0));
}

}  // namespace acus::test
