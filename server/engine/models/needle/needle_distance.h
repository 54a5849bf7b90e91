// SPDX-License-Identifier: GPL-3.0-or-later
// Where two needles are near each other.
//
// A needle is round with a hemispherical end: all points within its radius r of its curve a(s), s from 0 to its length
// less r. It is divided into cells, equal lengths of the curve. Between a cell of one needle, or two that follow each
// other, and all of another needle with the curve b(t), the nearest points are those with the least
//
//   |a(s) - b(t)|² + epsilon (s - m)²,    m the middle of the cell, or of the two.
//
// Without the second term the point would jump along needles that lie side by side. With it these touch in the middle
// of each cell. Where needles cross by an angle phi, s is drawn towards m by the share epsilon / (sin² phi + epsilon).
#pragma once

#include <optional>

#include "server/engine/models/needle/needle.h"

namespace acus {

// A needle's curve in one shape.
struct NeedleCells {
  double radius = 0;                                      // m
  double length = 0;                                      // m, of a cell
  Matrix3X ends;                                          // 3 x (cells + 1), m, world
  Vector3 low = Vector3::Zero(), high = Vector3::Zero();  // m, corners of a box around the curve

  // With so many cells.
  explicit NeedleCells(int cells) : ends(3, cells + 1) {}
  int count() const { return static_cast<int>(ends.cols()) - 1; }
  double end() const { return length * count(); }  // m, of the curve
};

void put_cells(const NeedleModel& model, const NeedleShape& shape, NeedleCells& cells);

struct NearestPoints {
  double s = 0, t = 0;              // m, along the needles
  Vector3 apart = Vector3::Zero();  // m, a(s) - b(t)
};

// A needle in the shape that its cells are of.
struct ShapedNeedle {
  const NeedleModel& model;
  const NeedleShape& shape;
  const NeedleCells& cells;
};

// Whether surfaces of two needles can be within `reach` (m) of each other; false if they surely are not.
bool may_be_within(const NeedleCells& a, const NeedleCells& b, double reach);

// Between the cells first to last of `a` and all of `b`, if their surfaces are within `reach` (m) there.
std::optional<NearestPoints> nearest_points(const ShapedNeedle& a, int first, int last, const ShapedNeedle& b,
                                            double reach);

}  // namespace acus
