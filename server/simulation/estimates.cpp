// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene may leave out and the material tells.
#include <cmath>
#include <numbers>

#include "server/simulation/scene.h"

namespace acus {

double shaft_pressure(const Region& region) {
  return region.interaction.pressure.value_or(region.material.young_modulus / (1 + region.material.poisson_ratio));
}

double foundation_compliance(const Material& material, double h, double d) {
  if (h <= d) return 0;
  const double nu = material.poisson_ratio, shear_modulus = material.young_modulus / (2 * (1 + nu));
  return (3 - 4 * nu) / (8 * std::numbers::pi * shear_modulus * (1 - nu)) * std::log(h / d);
}

}  // namespace acus
