// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/unresolved/dimple.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "server/engine/models/unresolved/local_compliance.h"

namespace acus {

namespace {

constexpr double kBlunt = 0.86;  // r_0/a
constexpr double kSpread = 2;
constexpr double kFolding = 2.1;  // beta
constexpr double kBearable = 3;   // f_e over stiffness and edge²
constexpr double kEven = 0.05;    // f_w over f_e, at least
constexpr double kDeeper = 3;     // D over s

// An even load on a disc of radius 1 has the mean displacement of a flat punch of this radius.
constexpr double kEvenLoad = 3 * std::numbers::pi * std::numbers::pi / 32;

double fourth_power(double x) { return x * x * x * x; }

// (r_d/sqrt f)⁴, of Indented::deep or folding.
double slope4(double stiffness, double deep) { return deep * deep / fourth_power(stiffness); }

// r, of r_0 = `least`.
double punch_radius(double least, double slope4, double f) {
  return std::sqrt(std::sqrt(fourth_power(least) + slope4 * f * f));
}

// r at f, of a beta with which elements that bear kSpread times as wide a disc do not fold.
double widest(const Indented& tissue, double d, double f) {
  return punch_radius(kBlunt * d / 2, slope4(tissue.stiffness, tissue.folding), f);
}

}  // namespace

Indented::Indented(const Moduli& moduli, double deep_indentation)
    : stiffness(2 * moduli.young / (1 - moduli.poisson * moduli.poisson)),
      deep(deep_indentation * moduli.young),
      folding(std::max(deep_indentation, kFolding) * moduli.young) {
  assert(deep_indentation >= 0);
}

Indented& Indented::operator+=(const Indented& other) {
  stiffness += other.stiffness;
  deep += other.deep;
  folding += other.folding;
  return *this;
}

DimpleSpring::DimpleSpring(const Indented& tissue, double edge, double d, double f_w)
    : punch_(1 / tissue.stiffness),
      slope4_(slope4(tissue.stiffness, tissue.deep)),
      least_(kBlunt * d / 2),
      mesh_(std::hypot(kSpread * widest(tissue, d, f_w), kOnSurface * edge)) {
  assert(edge > 0 && d > 0 && f_w >= 0 && std::isfinite(f_w));
}

double DimpleSpring::radius(double f) const { return punch_radius(least_, slope4_, f); }

double DimpleSpring::depth(double force) const {
  const double f = at_rest(force);
  return punch_ * f * (1 / radius(f) - 1 / mesh_);
}

double DimpleSpring::compliance(double force) const {
  const double f = at_rest(force), r = radius(f);
  const double deep = slope4_ * f * f / fourth_power(r);  // (r_d/r)⁴
  return std::max(0.0, punch_ * ((1 - deep / 2) / r - 1 / mesh_)) / stiffening();
}

// f D - the integral of D over f, which has a closed form.
double DimpleSpring::energy(double force) const {
  const double f = at_rest(force), r = radius(f), s = least_;
  const double rest = 2.0 / 3 * (r * r + r * s + s * s) / ((r + s) * (r * r + s * s));
  return punch_ * f * f * (1 / r - rest - 1 / (2 * mesh_));
}

double DimpleSpring::whole(double force) const {
  const double f = at_rest(force);
  return punch_ * f / radius(f);
}

double DimpleSpring::whole_compliance(double force) const { return compliance(force) + punch_ / mesh_ / stiffening(); }

double dimple_force(const Indented& tissue, double d, double D) {
  const double shallow = tissue.stiffness * kBlunt * d / 2 * D, deep = tissue.deep * D * D;
  return std::sqrt((deep * deep + std::hypot(deep * deep, 2 * shallow * shallow)) / 2);
}

double disc_load(const Indented& tissue, double edge, double d, double f_p, double f, double s) {
  assert(edge > 0 && f_p >= 0 && f >= 0 && s >= 0);
  const double f_e = kBearable * tissue.stiffness * edge * edge;
  return std::min(f_p, std::max({f, dimple_force(tissue, d, kDeeper * s), f_e * f_e / f_p, kEven * f_e}));
}

double dimple_radius(const Indented& tissue, double d, double f) {
  assert(d > 0 && f >= 0 && std::isfinite(f));
  return widest(tissue, d, f) / kEvenLoad;
}

double contact_radius(const Indented& tissue, double d, double f_w) { return kSpread * dimple_radius(tissue, d, f_w); }

}  // namespace acus
