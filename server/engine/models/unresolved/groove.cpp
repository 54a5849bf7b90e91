// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/unresolved/groove.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace acus {

namespace {

constexpr double kAcrossSurface = 0.31;  // c
// Added to the logarithm: two points of one element can be held.
constexpr double kLeastGive = 1e-4;
// Of the body beneath fixed nodes, in R.
constexpr double kBodyWidth = 10;

}  // namespace

GrooveSpring::GrooveSpring(const Moduli& moduli, double edge, double d, double length, double held)
    : line_(2 * (1 - moduli.poisson * moduli.poisson) / (std::numbers::pi * moduli.young)),
      spread_(2 * moduli.young),
      radius_(d / 2),
      more_(std::max(0.0, kAcrossSurface * edge - d / 2)),
      give_(kLeastGive + held * std::log(kBodyWidth)),
      length_(length) {
  assert(edge >= 0 && d > 0 && length > 0 && held >= 0);
}

double GrooveSpring::width(double f) const { return std::hypot(radius_, f / (length_ * spread_)); }

double GrooveSpring::depth(double force) const {
  const double f = at_rest(force);
  return line_ * f / length_ * (std::log1p(more_ / width(f)) + give_);
}

double GrooveSpring::compliance(double force) const {
  const double rho = width(at_rest(force)), wide = rho * rho - radius_ * radius_;
  return line_ / length_ * (std::log1p(more_ / rho) - more_ * wide / (rho * rho * (rho + more_)) + give_) /
         stiffening();
}

double GrooveSpring::integral(double rho) const {
  return (rho * rho * std::log1p(more_ / rho) + more_ * (rho - more_ * std::log(rho + more_))) / 2;
}

// f D - the integral of D over f, with q dq = (2 E)² rho d(rho).
double GrooveSpring::energy(double force) const {
  const double f = at_rest(force);
  const double rest =
      line_ * (spread_ * spread_ * length_ * (integral(width(f)) - integral(radius_)) + give_ * f * f / (2 * length_));
  return f * depth(force) - rest;
}

}  // namespace acus
