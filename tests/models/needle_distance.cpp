// SPDX-License-Identifier: GPL-3.0-or-later
// Nearest points of two needles against a search on a grid, for random bent needles that pass each other closely.
#include "server/engine/models/needle/needle_distance.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"
#include "tests/models/bench_needle.h"

namespace acus {
namespace {

constexpr double kEpsilon = 2e-3;  // as in needle_distance.cpp

struct Bent {
  NeedleModel model;
  NeedleShape shape;
  NeedleCells cells;

  ShapedNeedle view() const { return {model, shape, cells}; }
  Vector3 at(double s) const { return curve_point(model, shape, s).position; }
};

NeedleModel short_needle() {
  NeedleBody body = bench_body();
  body.length = 0.1;
  body.beams = 20;
  body.outer_diameter = 1e-3;
  return make_needle_model(body, Vector3::Zero());
}

// A smooth curve, bent by `bend` (rad) at each beam at most, whose node `node` is at `through`.
Bent bent_needle(Random& random, double bend, const Vector3& through, int node) {
  Bent needle{short_needle(), {}, NeedleCells(8)};
  NeedleShape& shape = needle.shape;
  shape.x.setZero(3, needle.model.nodes());
  const Vector3 turn = bend * random.direction();
  Quaternion q = random.rotation();
  for (int i = 0; i < needle.model.nodes(); ++i) {
    shape.frames.push_back(q.toRotationMatrix());
    if (i + 1 == needle.model.nodes()) break;
    const Quaternion next = rotation_exp(turn) * q;
    const Vector3 along = (q * Vector3::UnitX() + next * Vector3::UnitX()).normalized();
    shape.x.col(i + 1) = shape.x.col(i) + needle.model.beam_length() * along;
    q = next;
  }
  shape.x.colwise() += through - Vector3(shape.x.col(node));
  put_cells(needle.model, shape, needle.cells);
  return needle;
}

double middle(const Bent& needle, int cell) { return (cell + 0.5) * needle.cells.length; }

// The square of the distance with the draw towards the cell's middle.
double cost(const Bent& a, int cell, const Bent& b, double s, double t) {
  const double off = s - middle(a, cell);
  return (a.at(s) - b.at(t)).squaredNorm() + kEpsilon * off * off;
}

// By grids, each finer than the one before and around its best point.
double least_cost(const Bent& a, int cell, const Bent& b) {
  constexpr int kPoints = 40;
  const double from = a.cells.length * cell, to = from + a.cells.length, end = b.cells.end();
  double least = 1, s = (from + to) / 2, t = end / 2, width_s = (to - from) / 2, width_t = end / 2;
  for (int level = 0; level < 7; ++level) {
    const double middle_s = s, middle_t = t;
    for (int i = -kPoints; i <= kPoints; ++i)
      for (int j = -kPoints; j <= kPoints; ++j) {
        const double si = std::clamp(middle_s + width_s * i / kPoints, from, to);
        const double tj = std::clamp(middle_t + width_t * j / kPoints, 0.0, end);
        const double found = cost(a, cell, b, si, tj);
        if (found < least) least = found, s = si, t = tj;
      }
    width_s /= 10;
    width_t /= 10;
  }
  return least;
}

}  // namespace

TEST_CASE("the nearest points of needles that pass each other are those that a search finds") {
  Random random(7);
  int found = 0;
  for (int run = 0; run < 12; ++run) {
    const double bend = run % 3 == 0 ? 0 : random.uniform(0, 0.05);
    const Bent a = bent_needle(random, bend, Vector3::Zero(), random.index(21));
    const Bent b = bent_needle(random, bend, random.vector(2e-3), random.index(21));
    const double reach = 5e-3, surfaces = 1e-3;
    for (int cell = 0; cell < a.cells.count(); ++cell) {
      const double least = least_cost(a, cell, b);
      const auto points = nearest_points(a.view(), cell, cell, b.view(), reach);
      if (!points) {
        // What is drawn to the middle may be farther apart than what is nearest.
        CHECK(std::sqrt(least) > 0.98 * (reach + surfaces));
        continue;
      }
      ++found;
      CHECK(may_be_within(a.cells, b.cells, reach));
      CHECK((points->apart - (a.at(points->s) - b.at(points->t))).norm() < 1e-15);
      CHECK(std::sqrt(cost(a, cell, b, points->s, points->t)) < std::sqrt(least) + 1e-6);
    }
  }
  CHECK(found > 20);
}

TEST_CASE("needles side by side touch in the middle of each cell, and crossing ones where they cross") {
  Random random(3);
  Bent a = bent_needle(random, 0, Vector3::Zero(), 0), b = a;
  const Vector3 along = a.shape.frames[0].col(0), across = along.unitOrthogonal();
  b.shape.x.colwise() += 1.2e-3 * across;
  put_cells(b.model, b.shape, b.cells);
  for (int cell = 0; cell < a.cells.count(); ++cell) {
    const auto points = nearest_points(a.view(), cell, cell, b.view(), 1e-3);
    REQUIRE(points);
    CHECK(points->s == doctest::Approx(middle(a, cell)));
    CHECK(points->t == doctest::Approx(middle(a, cell)));
    CHECK(points->apart.norm() == doctest::Approx(1.2e-3));
  }
  CHECK_FALSE(nearest_points(a.view(), 0, 0, b.view(), 0.1e-3));
  CHECK(may_be_within(a.cells, b.cells, 1e-3));
  b.shape.x.colwise() += 0.2 * across;
  put_cells(b.model, b.shape, b.cells);
  CHECK_FALSE(may_be_within(a.cells, b.cells, 1e-3));
}

TEST_CASE("a needle ends in a hemisphere whose pole is its tip") {
  Random random(5);
  Bent lying = bent_needle(random, 0, Vector3::Zero(), 10), standing = lying;
  constexpr double kAbove = 1.3e-3;  // m, of the tip over the axis of the one that lies
  const Matrix3 frame = lying.shape.frames[0];
  for (int i = 0; i < standing.model.nodes(); ++i) {
    standing.shape.frames[static_cast<std::size_t>(i)] << -frame.col(1), frame.col(0), frame.col(2);
    const double beyond = kAbove + standing.model.beam_length() * (standing.model.beams - i);
    standing.shape.x.col(i) = beyond * frame.col(1);
  }
  put_cells(standing.model, standing.shape, standing.cells);
  const auto points = nearest_points(standing.view(), 7, 7, lying.view(), 1e-3);
  REQUIRE(points);
  CHECK(points->s == doctest::Approx(0.1 - 0.5e-3));
  CHECK(points->apart.norm() == doctest::Approx(kAbove + 0.5e-3));
}

}  // namespace acus
