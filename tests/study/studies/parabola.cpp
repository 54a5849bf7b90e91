// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/parabola.h"

#include <cassert>
#include <cmath>

#include "server/engine/math/types.h"

namespace acus {

double parabola_curvature(const std::vector<double>& xs, const std::vector<double>& ys, double middle) {
  assert(xs.size() == ys.size() && xs.size() >= 3);
  const auto n = static_cast<Eigen::Index>(xs.size());
  const Eigen::Map<const Eigen::ArrayXd> x(xs.data(), n);
  MatrixX powers(n, 3);
  powers << VectorX::Ones(n), x.matrix(), x.square().matrix();
  const VectorX fit = powers.colPivHouseholderQr().solve(Eigen::Map<const VectorX>(ys.data(), n));
  const double slope = fit[1] + 2 * fit[2] * middle;
  return 2 * fit[2] / std::pow(1 + slope * slope, 1.5);
}

}  // namespace acus
