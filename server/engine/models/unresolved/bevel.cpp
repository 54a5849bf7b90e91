// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/unresolved/bevel.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace acus {

namespace {

// k (Pa) along a needle of radius a (m) that bends within 1/lambda (m). What bends within less than its diameter is no
// needle.
double beside_needle(const Moduli& moduli, double a, double lambda) {
  const double nu = moduli.poisson, b = std::min(2 * lambda * a, 1.0);
  return 16 * std::numbers::pi * moduli.shear() * (1 - nu) /
         (2 * (3 - 4 * nu) * std::cyl_bessel_k(0, b) + b * std::cyl_bessel_k(1, b));
}

}  // namespace

BevelPath bevel_path(const Bevel& bevel, const BevelledTissue& tissue) {
  assert(bevel.diameter > 0 && bevel.bending > 0 && bevel.face > 0);
  constexpr int kIterations = 20;  // k changes with the logarithm of lambda
  const double d = bevel.diameter;
  double lambda = 0.1 / d, k = 0;
  for (int i = 0; i < kIterations; ++i) {
    k = beside_needle(tissue.moduli, d / 2, lambda);
    lambda = std::pow(k / (4 * bevel.bending), 0.25);
  }
  const double e = std::min(bevel.offset, tissue.tear_strength / k);
  const double u = lambda * d / std::tan(bevel.face), q = tissue.cutting_force / (2 * bevel.bending * lambda * lambda);
  const double gamma = lambda * e * (1 + std::exp(-u) * (std::sin(u) - std::cos(u))) / (u * (1 + q));
  const double turn = std::exp(-u) * std::sin(u) / u;
  const double curvature = 2 * lambda * lambda * e * (turn + q) - 2 * lambda * q * gamma;
  const double held = 1.07 + 2 * lambda * d + q;  // C
  return {std::max(0.0, curvature), std::max(0.0, curvature) / (held * lambda), q};
}

}  // namespace acus
