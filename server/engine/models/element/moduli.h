// SPDX-License-Identifier: GPL-3.0-or-later
// The isotropic linear solid that answers small loads as a material does: what loads that the mesh does not resolve
// (models/unresolved) and pressures of tissue ask for. No other law reads Young's modulus or Poisson's ratio of tissue.
#pragma once

#include "server/engine/models/element/hooke.h"
#include "server/engine/models/element/material.h"

namespace acus {

struct Moduli {
  double young;    // E (Pa)
  double poisson;  // nu (-)

  Moduli(const Material& material) : young(material.young_modulus), poisson(material.poisson_ratio) {}

  double shear() const { return young / (2 * (1 + poisson)); }                           // G (Pa)
  double lame() const { return young * poisson / ((1 + poisson) * (1 - 2 * poisson)); }  // lambda (Pa)
};

// The law of a material's elements.
inline Hooke<double> hooke(const Moduli& moduli) { return {moduli.shear(), moduli.lame()}; }

}  // namespace acus
