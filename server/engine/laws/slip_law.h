// SPDX-License-Identifier: GPL-3.0-or-later
// Friction over the size s of a slip,
//
//   |lambda| = T + c s (1 + s/s_t)^(n - 1),
//
// Coulomb's with a viscous part that thins: c s of slow slips, c s_t^(1 - n) s^n of fast ones [the shape is that of
// Carreau 1972 and Yasuda 1979, with a = 1]. n = 0 has an end, c s_t; n = 1, or s_t infinite, is linear. It rises and
// is concave for every n in [0, 1], and so has a tangent from rest on, which a power alone has not.
#pragma once

#include <cmath>
#include <limits>

namespace acus {

struct SlipLaw {
  double threshold = 0;                                       // T (N), >= 0
  double viscosity = 0;                                       // c (N/m), >= 0: force per slip in this tick, from rest
  double thinning = std::numeric_limits<double>::infinity();  // s_t (m), > 0: slip in this tick from which it thins
  double exponent = 0;                                        // n (-), in [0, 1]

  bool is_linear() const { return viscosity == 0 || exponent == 1 || std::isinf(thinning); }
  // N, at a slip (m), >= 0.
  double force(double slip) const { return threshold + viscosity * slip * thinned(slip); }
  // N/m, of force().
  double slope(double slip) const {
    const double more = slip / thinning;
    return viscosity * thinned(slip) * (1 + exponent * more) / (1 + more);
  }

 private:
  double thinned(double slip) const { return is_linear() ? 1 : std::pow(1 + slip / thinning, exponent - 1); }
};

}  // namespace acus
