// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/local_compliance.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace acus {

namespace {

// c: a mesh of edge length `edge` answers as a needle of radius c edge does.
constexpr double kAlong = 0.43;
constexpr double kAhead = 0.57;

double shear_modulus(const Material& material) { return material.young_modulus / (2 * (1 + material.poisson_ratio)); }

// With A/r (m/N) the give at the radius r: what a point force up to f gives more at b than at the `resolved` radius (m).
double point_compliance(double A, double a, double resolved, double f) {
  assert(A > 0 && a > 0 && resolved > 0 && !(f < 0));
  const double b = std::max(a, std::sqrt(A * f));
  return b < resolved ? A * (1 / b - 1 / resolved) : 0;
}

}  // namespace

double foundation_compliance(const Material& material, double edge, double d) {
  assert(edge > 0 && d > 0);
  if (edge <= d) return 0;
  const double nu = material.poisson_ratio;
  return (3 - 4 * nu) / (8 * std::numbers::pi * shear_modulus(material) * (1 - nu)) * std::log(edge / d);
}

double axial_compliance(const Material& material, double edge, double d) {
  assert(edge > 0 && d > 0);
  return std::log(std::max(1.0, 2 * kAlong * edge / d)) / (2 * std::numbers::pi * shear_modulus(material));
}

double end_compliance(const Material& material, double edge, double d) { return tip_compliance(material, edge, d, 0); }

double tip_compliance(const Material& material, double edge, double d, double f) {
  const double nu = material.poisson_ratio;
  const double A = (5 - 6 * nu) / (24 * std::numbers::pi * shear_modulus(material) * (1 - nu));
  return point_compliance(A, d / 2, kAhead * edge, f);
}

}  // namespace acus
