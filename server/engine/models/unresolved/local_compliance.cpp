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

// A: a point force gives A/r (m/N) at the radius r.
double point_give(const Moduli& moduli) {
  const double nu = moduli.poisson;
  return (5 - 6 * nu) / (24 * std::numbers::pi * moduli.shear() * (1 - nu));
}

}  // namespace

double foundation_compliance(const Moduli& moduli, double edge, double d) {
  assert(edge > 0 && d > 0);
  if (edge <= d) return 0;
  const double nu = moduli.poisson;
  return (3 - 4 * nu) / (8 * std::numbers::pi * moduli.shear() * (1 - nu)) * std::log(edge / d);
}

double axial_compliance(const Moduli& moduli, double edge, double d) {
  const auto [inner, outer] = shaft_radii(edge, d);
  return std::log(std::max(1.0, outer / inner)) / (2 * std::numbers::pi * moduli.shear());
}

double surface_displacement(const Moduli& moduli, double edge, double d, double q, double L) {
  const auto [inner, outer] = shaft_radii(edge, d);
  return q / (2 * std::numbers::pi * moduli.shear()) * std::log(std::max(1.0, std::min(outer, L) / inner));
}

double mouth_displacement(const Moduli& moduli, double edge, double d, double q, double length) {
  constexpr int kIterations = 8;
  const auto [inner, outer] = shaft_radii(edge, d);
  const auto u = [&](double L) { return surface_displacement(moduli, edge, d, q, L); };
  if (q <= 0 || u(length) == 0 || length - u(length) >= outer) return u(length);
  // Newton on L + u(L) = length, which is concave: from below.
  const double slope = q / (2 * std::numbers::pi * moduli.shear());
  double L = inner;
  for (int i = 0; i < kIterations; ++i) L += (length - L - u(L)) / (1 + slope / L);
  return u(L);
}

double end_compliance(const Moduli& moduli, double edge, double d) { return tip_compliance(moduli, edge, d, 0); }

double tip_compliance(const Moduli& moduli, double edge, double d, double f) {
  const LoadRadii radii = tip_radii(moduli, edge, d, f);
  return radii.resolved() ? 0 : point_give(moduli) * (1 / radii.inner - 1 / radii.outer);
}

LoadRadii shaft_radii(double edge, double d) {
  assert(edge > 0 && d > 0);
  return {d / 2, kAlong * edge};
}

LoadRadii tip_radii(const Moduli& moduli, double edge, double d, double f) {
  assert(edge > 0 && d > 0 && !(f < 0));
  return {std::max(d / 2, std::sqrt(point_give(moduli) * f)), kAhead * edge};
}

}  // namespace acus
