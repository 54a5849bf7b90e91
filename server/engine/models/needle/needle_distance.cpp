// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/needle_distance.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace acus {

namespace {

constexpr double kDraw = 2e-3;  // epsilon: needles that cross by less than 2.6 degrees count as side by side
constexpr int kSteps = 5;  // towards the nearest points; each takes the curves' bend times their distance off the error

// A straight line p + x d, from x = low to high (m).
struct Line {
  Vector3 p, d;  // d unit
  double low, high;

  double within(double x) const { return std::clamp(x, low, high); }
};

struct Pair {
  double x, y;
};

// x and y with the least |a(x) - b(y)|² + draw (x - m)²: the unbounded minimum, or that on the bounds which it is
// beyond [Ericson 2005, section 5.1.9].
Pair nearest_on_lines(const Line& a, const Line& b, double draw, double m) {
  const Vector3 apart = a.p - b.p;
  const double c = a.d.dot(b.d), of_a = -apart.dot(a.d) + draw * m, of_b = apart.dot(b.d);
  const double across = 1 + draw - c * c;
  double x = across > 1e-12 ? a.within((of_a + c * of_b) / across) : a.within(m);
  double y = of_b + c * x;
  if (y != b.within(y)) {
    y = b.within(y);
    x = a.within((of_a + c * y) / (1 + draw));
  }
  return {x, y};
}

// From end to end of a cell.
Line chord(const NeedleCells& cells, int cell) {
  const Vector3 from = cells.ends.col(cell), along = cells.ends.col(cell + 1) - from;
  const double length = along.norm();
  return {from, length > 0 ? Vector3(along / length) : Vector3::UnitX(), 0, length};
}

Vector3 middle(const NeedleCells& cells, int cell) { return (cells.ends.col(cell) + cells.ends.col(cell + 1)) / 2; }

// The points of two cells' chords: a first guess of s and t. Returns their distance (m).
double guess(const NeedleCells& a, int i, const NeedleCells& b, int j, NearestPoints& points) {
  const Line of_a = chord(a, i), of_b = chord(b, j);
  const auto [x, y] = nearest_on_lines(of_a, of_b, kDraw, of_a.high / 2);
  points.s = a.length * i + std::min(x, a.length);
  points.t = b.length * j + std::min(y, b.length);
  return (of_a.p + x * of_a.d - of_b.p - y * of_b.d).norm();
}

}  // namespace

void put_cells(const NeedleModel& model, const NeedleShape& shape, NeedleCells& cells) {
  cells.radius = model.diameter / 2;
  cells.length = std::max(0.0, model.length - cells.radius) / cells.count();
  for (int i = 0; i <= cells.count(); ++i) cells.ends.col(i) = curve_point(model, shape, cells.length * i).position;
  cells.low = cells.ends.rowwise().minCoeff();
  cells.high = cells.ends.rowwise().maxCoeff();
  double bulge = 0;  // of an arc beside its chord: that of two straight lines as long as the arc
  for (int i = 0; i < cells.count(); ++i) {
    const double square = (cells.ends.col(i + 1) - cells.ends.col(i)).squaredNorm();
    bulge = std::max(bulge, cells.length * cells.length - square);
  }
  const double beside = std::sqrt(std::max(0.0, bulge)) / 2;
  cells.low.array() -= beside;
  cells.high.array() += beside;
}

bool may_be_within(const NeedleCells& a, const NeedleCells& b, double reach) {
  const double most = a.radius + b.radius + reach;
  return (a.low.array() - most <= b.high.array()).all() && (b.low.array() - most <= a.high.array()).all();
}

std::optional<NearestPoints> nearest_points(const ShapedNeedle& a, int first, int last, const ShapedNeedle& b,
                                            double reach) {
  assert(first >= 0 && first <= last && last < a.cells.count());
  const double surfaces = a.cells.radius + b.cells.radius;
  const double most = (a.cells.length + b.cells.length) / 2 + surfaces + reach;
  std::optional<NearestPoints> best;
  double least = 0;
  for (int i = first; i <= last; ++i)
    for (int j = 0; j < b.cells.count(); ++j) {
      if ((middle(a.cells, i) - middle(b.cells, j)).squaredNorm() > most * most) continue;
      NearestPoints points;
      const double distance = guess(a.cells, i, b.cells, j, points);
      if (best && distance >= least) continue;
      best = points;
      least = distance;
    }
  if (!best) return std::nullopt;
  const double from = a.cells.length * first, to = a.cells.length * (last + 1), end = b.cells.end();
  for (int step = 0; step < kSteps; ++step) {
    const CurvePoint on_a = curve_point(a.model, a.shape, best->s), on_b = curve_point(b.model, b.shape, best->t);
    const Line line_a{on_a.position, on_a.tangent, from - best->s, to - best->s};
    const Line line_b{on_b.position, on_b.tangent, -best->t, end - best->t};
    const auto [x, y] = nearest_on_lines(line_a, line_b, kDraw, (from + to) / 2 - best->s);
    best->s += x;
    best->t += y;
  }
  best->apart = curve_point(a.model, a.shape, best->s).position - curve_point(b.model, b.shape, best->t).position;
  if (best->apart.norm() > surfaces + reach) return std::nullopt;
  return best;
}

}  // namespace acus
