// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers for tests and studies that are the same on every machine (the standard library's distributions are not).
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "server/engine/math/rotation.h"
#include "server/engine/math/types.h"

namespace acus {

class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}

  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(generator_()) / static_cast<double>(std::mt19937::max());
  }
  int index(int count) { return static_cast<int>(generator_() % static_cast<unsigned>(count)); }

  // Entries within [-size, size].
  MatrixX matrix(Eigen::Index rows, Eigen::Index columns, double size = 1) {
    return MatrixX::NullaryExpr(rows, columns,
                                [this, size](Eigen::Index, Eigen::Index) { return uniform(-size, size); });
  }
  Vector3 vector(double size = 1) { return matrix(3, 1, size); }

  Vector3 direction() {
    const double z = uniform(-1, 1), angle = uniform(-std::numbers::pi, std::numbers::pi);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }
  Quaternion rotation(double max_angle = std::numbers::pi) { return rotation_exp(uniform(0, max_angle) * direction()); }

 private:
  std::mt19937 generator_;
};

}  // namespace acus
