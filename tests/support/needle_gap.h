// SPDX-License-Identifier: GPL-3.0-or-later
// How far two needles are apart, by a search through the pieces of their curves.
#pragma once

#include <algorithm>

#include "server/engine/models/needle/needle.h"

namespace acus::test {

// Of two segments, by their ends.
inline double segment_distance(const Vector3& a0, const Vector3& a1, const Vector3& b0, const Vector3& b1) {
  const Vector3 u = a1 - a0, v = b1 - b0;
  double least = 1e9;
  const auto try_at = [&](double s, double t) { least = std::min(least, (a0 + s * u - b0 - t * v).norm()); };
  const auto onto = [](const Vector3& p, const Vector3& from, const Vector3& along) {
    return std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
  };
  for (const double end : {0.0, 1.0}) {
    try_at(end, onto(a0 + end * u, b0, v));
    try_at(onto(b0 + end * v, a0, u), end);
  }
  const double uu = u.dot(u), vv = v.dot(v), uv = u.dot(v), det = uu * vv - uv * uv;
  if (det > 1e-12 * uu * vv) {
    const Vector3 w = b0 - a0;
    const double s = (w.dot(u) * vv - w.dot(v) * uv) / det, t = (w.dot(u) * uv - w.dot(v) * uu) / det;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) try_at(s, t);
  }
  return least;
}

// Between the surfaces of two needles (m), negative where they overlap: chords of `pieces` pieces of each curve.
inline double needle_gap(const NeedleModel& a, const NeedleState& at_a, const NeedleModel& b, const NeedleState& at_b,
                         int pieces = 40) {
  const auto points = [pieces](const NeedleModel& model, const NeedleState& state) {
    NeedleShape shape;
    put_shape(state, shape);
    Matrix3X x(3, pieces + 1);
    for (int i = 0; i <= pieces; ++i)
      x.col(i) = curve_point(model, shape, (model.length - model.diameter / 2) * i / pieces).position;
    return x;
  };
  const Matrix3X x = points(a, at_a), y = points(b, at_b);
  double least = 1e9;
  for (int i = 0; i < pieces; ++i)
    for (int j = 0; j < pieces; ++j)
      least = std::min(least, segment_distance(x.col(i), x.col(i + 1), y.col(j), y.col(j + 1)));
  return least - (a.diameter + b.diameter) / 2;
}

}  // namespace acus::test
