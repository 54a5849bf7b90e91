// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/contact_block.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace acus {

namespace {

using Vector2 = Eigen::Vector2d;

constexpr int kRootSteps = 60;
constexpr int kDoublings = 40;

// Where in (low, high) a function changes its sign from plus to minus: by inverse quadratic interpolation where the
// last three points are fit for it, else by bisection [Chandrupatla 1997, "A new hybrid quadratic/bisection algorithm
// for finding the zero of a nonlinear function without using derivatives", Adv. Eng. Softw. 28].
template <class Function>
double find_root(double low, double high, Function f) {
  double a = high, b = low, fa = f(high), fb = f(low);
  if (!(fb > 0)) return low;
  if (!(fa < 0)) return high;
  double share = 0.5;
  for (int i = 0; i < kRootSteps; ++i) {
    const double x = a + share * (b - a), fx = f(x);
    double c = a, fc = fa;
    if ((fx > 0) == (fa > 0)) {
      a = x, fa = fx;
    } else {
      c = b, fc = fb;
      b = a, fb = fa;
      a = x, fa = fx;
    }
    const double best = std::abs(fa) < std::abs(fb) ? a : b;
    const double room = 2 * std::numeric_limits<double>::epsilon() * std::abs(best) / std::abs(b - a);
    if (room > 0.5 || fx == 0) return best;
    const double xi = (a - b) / (c - b), phi = (fa - fb) / (fc - fb);
    const bool fits = phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi;
    share = fits ? fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb) : 0.5;
    share = std::clamp(share, room, 1 - room);
  }
  return std::abs(fa) < std::abs(fb) ? a : b;
}

// The a in (0, infinity) at which `excess` changes its sign from plus to minus.
template <class Excess>
double find_rim(double scale, Excess excess) {
  const auto multiplier = [&](double s) { return scale * s / (1 - s); };
  constexpr double kAlmostOne = 1 - 1e-15;  // keeps the multiplier finite
  return multiplier(find_root(0.0, kAlmostOne, [&](double s) { return excess(multiplier(s)); }));
}

// Where a point slips: t(g) = -(W + g I)⁻¹ bar, in axes in which its ellipse is a circle. The g > 0 at which |t| is the
// law's friction is the root of F/|t| - 1. Where F is straight that rises ever less, so Newton's method, once below
// the root, never goes too far [as for trust regions: More, Sorensen 1983, "Computing a trust region step"]; where it
// does, the middle of what is left is taken.
struct Rim {
  const SlipLaw& law;
  Vector2 axes;
  Eigen::Matrix2d W;
  Vector2 bar;

  Vector2 solve(double g, const Vector2& right) const {
    const double a = W(0, 0) + g, b = W(1, 0), c = W(1, 1) + g;
    return Vector2(c * right[0] - b * right[1], a * right[1] - b * right[0]) / (a * c - b * b);
  }
  Vector2 force(double g) const { return solve(g, -bar); }
  double slip(double g, const Vector2& t) const { return g * t.cwiseQuotient(axes).norm(); }
  double limit(double g, const Vector2& t) const { return law.force(slip(g, t)); }

  double find(double g) const {
    double low = 0, high = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kRootSteps; ++i) {
      const Vector2 t = force(g), change = solve(g, -t), unit = t.cwiseQuotient(axes);
      const double size = t.norm(), along = unit.norm(), s = g * along, F = law.force(s);
      const double excess = F / size - 1;
      if (!(size > 0) || std::abs(excess) <= 2 * std::numeric_limits<double>::epsilon()) break;
      (excess < 0 ? low : high) = g;
      const double more = along + g * unit.dot(change.cwiseQuotient(axes)) / along;  // ds/dg
      const double slope = (law.slope(s) * more - F * t.dot(change) / (size * size)) / size;
      double next = g - excess / slope;
      if (!(next > low)) next = std::isfinite(high) ? (low + high) / 2 : 2 * std::max(g, W.trace());
      if (!(next < high)) next = (low + high) / 2;
      if (std::abs(next - g) <= std::numeric_limits<double>::epsilon() * next) return next;
      g = next;
    }
    return g;
  }
};

}  // namespace

Vector3 contact_force(const ContactLaw& law, const Matrix3& W, const Vector3& delta_bar) {
  assert(law.limit >= 0 && law.friction >= 0 && law.cohesion >= 0 && !(W.diagonal().minCoeff() <= 0));
  const auto with_normal = [&](double n) {
    const Vector2 bar = delta_bar.tail<2>() + n * W.block<2, 1>(1, 0);
    const Vector2 t =
        disk_contact({.threshold = law.cohesion + law.friction * n}, W.bottomRightCorner<2, 2>(), bar).force;
    return Vector3(n, t[0], t[1]);
  };
  const auto force = [&](double a) {
    Matrix3 system = W;
    system.diagonal().tail<2>().array() += a;
    return Vector3(-system.inverse() * delta_bar);
  };
  const auto excess = [&](const Vector3& lambda) {
    return lambda.tail<2>().norm() - (law.cohesion + law.friction * lambda[0]);
  };

  Vector3 lambda = force(0);
  if (excess(lambda) > 0) {
    const Vector3 without_friction(-delta_bar[0] / W(0, 0), 0, 0);
    lambda = excess(without_friction) < 0 ? force(find_rim(W.trace(), [&](double a) { return excess(force(a)); }))
                                          : without_friction;
  }
  if (lambda[0] > 0 && lambda[0] < law.limit) return lambda;
  // Open or at its cap, unless the friction of that would press the tip on, or off.
  const auto approach = [&](double n) { return -(W.row(0).dot(with_normal(n)) + delta_bar[0]); };
  if (approach(0) <= 0) return with_normal(0);
  if (std::isfinite(law.limit) && approach(law.limit) >= 0) return with_normal(law.limit);
  double high = std::min(law.limit, delta_bar.norm() / W(0, 0));
  for (int i = 0; i < kDoublings && approach(high) > 0 && high < law.limit; ++i) high = std::min(2 * high, law.limit);
  return with_normal(find_root(0.0, high, approach));
}

DiskContact disk_contact(const SlipLaw& law, const Eigen::Matrix2d& W, const Vector2& delta_bar, double stretch,
                         const Vector2& near) {
  assert(!(law.threshold < 0) && !(law.viscosity < 0) && stretch > 0);
  if (law.threshold == 0 && law.viscosity == 0) return {Vector2::Zero(), delta_bar, true};
  // By the half axes the ellipse is a circle.
  const Vector2 axes(stretch, 1);
  const Rim rim{law, axes, axes.asDiagonal() * W * axes.asDiagonal(), axes.cwiseProduct(delta_bar)};
  const Vector2 stuck = rim.force(0);
  if (stuck.norm() <= law.threshold) return {axes.cwiseProduct(stuck), Vector2::Zero(), false};
  const double begin = axes.cwiseProduct(near).norm();
  const double g = rim.find(begin > 0 && law.force(near.norm()) > 0 ? begin / law.force(near.norm()) : 0);
  const Vector2 direction = rim.force(g), t = rim.limit(g, direction) * direction.normalized();
  return {axes.cwiseProduct(t), -g * t.cwiseQuotient(axes), true};
}

}  // namespace acus
