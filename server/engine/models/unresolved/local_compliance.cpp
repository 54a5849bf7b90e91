// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/unresolved/local_compliance.h"

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

// A: a point force gives A/r (m/N) at the radius r.
double point_give(const Material& material) {
  const double nu = material.poisson_ratio;
  return (5 - 6 * nu) / (24 * std::numbers::pi * shear_modulus(material) * (1 - nu));
}

}  // namespace

double foundation_compliance(const Material& material, double edge, double d) {
  assert(edge > 0 && d > 0);
  if (edge <= d) return 0;
  const double nu = material.poisson_ratio;
  return (3 - 4 * nu) / (8 * std::numbers::pi * shear_modulus(material) * (1 - nu)) * std::log(edge / d);
}

double axial_compliance(const Material& material, double edge, double d) {
  const auto [inner, outer] = shaft_radii(edge, d);
  return std::log(std::max(1.0, outer / inner)) / (2 * std::numbers::pi * shear_modulus(material));
}

double surface_displacement(const Material& material, double edge, double d, double q, double L) {
  const auto [inner, outer] = shaft_radii(edge, d);
  return q / (2 * std::numbers::pi * shear_modulus(material)) * std::log(std::max(1.0, std::min(outer, L) / inner));
}

double mouth_displacement(const Material& material, double edge, double d, double q, double length) {
  constexpr int kIterations = 8;
  const auto [inner, outer] = shaft_radii(edge, d);
  const auto u = [&](double L) { return surface_displacement(material, edge, d, q, L); };
  if (q <= 0 || u(length) == 0 || length - u(length) >= outer) return u(length);
  // Newton on L + u(L) = length, which is concave: from below.
  const double slope = q / (2 * std::numbers::pi * shear_modulus(material));
  double L = inner;
  for (int i = 0; i < kIterations; ++i) L += (length - L - u(L)) / (1 + slope / L);
  return u(L);
}

double end_compliance(const Material& material, double edge, double d) { return tip_compliance(material, edge, d, 0); }

double tip_compliance(const Material& material, double edge, double d, double f) {
  const LoadRadii radii = tip_radii(material, edge, d, f);
  return radii.resolved() ? 0 : point_give(material) * (1 / radii.inner - 1 / radii.outer);
}

LoadRadii shaft_radii(double edge, double d) {
  assert(edge > 0 && d > 0);
  return {d / 2, kAlong * edge};
}

LoadRadii tip_radii(const Material& material, double edge, double d, double f) {
  assert(edge > 0 && d > 0 && !(f < 0));
  return {std::max(d / 2, std::sqrt(point_give(material) * f)), kAhead * edge};
}

}  // namespace acus
