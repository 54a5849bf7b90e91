// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/errors.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace acus {

namespace {

// A Deviation of the vectors that it is given.
class Accumulator {
 public:
  void add(const Vector3& difference) { lengths_.push_back(difference.norm()); }

  Deviation result() {
    if (lengths_.empty()) return {};
    const Eigen::Map<const VectorX> all(lengths_.data(), static_cast<Eigen::Index>(lengths_.size()));
    const Deviation result{all.maxCoeff(), all.norm() / std::sqrt(static_cast<double>(lengths_.size())), 0};
    const auto place = lengths_.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(lengths_.size() - 1));
    std::nth_element(lengths_.begin(), place, lengths_.end());
    return {result.max, result.rms, *place};
  }

 private:
  std::vector<double> lengths_;
};

constexpr double kSameTick = 1e-9;  // ticks

// A series at time t, column k holding what is at (k + 1) h; before the first column and after the last it stays.
Vector3 at(const Matrix3X& series, double h, double t) {
  double place = std::clamp(t / h - 1, 0.0, static_cast<double>(series.cols() - 1));
  if (std::abs(place - std::round(place)) < kSameTick) place = std::round(place);
  const auto before = static_cast<Eigen::Index>(place);
  const auto after = std::min(before + 1, series.cols() - 1);
  const double u = place - static_cast<double>(before);
  return (1 - u) * series.col(before) + u * series.col(after);
}

Deviation deviation(const std::vector<Matrix3X>& run, double h, const std::vector<Matrix3X>& reference,
                    double reference_h) {
  assert(run.size() == reference.size());
  Accumulator all;
  for (std::size_t i = 0; i < run.size(); ++i)
    for (Eigen::Index k = 0; k < run[i].cols(); ++k)
      all.add(run[i].col(k) - at(reference[i], reference_h, static_cast<double>(k + 1) * h));
  return all.result();
}

Deviation deviation(const std::vector<Matrix3X>& run, const std::vector<Matrix3X>& reference) {
  Accumulator all;
  for (std::size_t i = 0; i < std::min(run.size(), reference.size()); ++i)
    for (Eigen::Index k = 0; k < run[i].cols(); ++k) all.add(run[i].col(k) - reference[i].col(k));
  return all.result();
}

// Every column less the first one, or, for `from` zero, as it is.
Deviation magnitude(const std::vector<Matrix3X>& series, double from) {
  Accumulator all;
  for (const Matrix3X& one : series)
    for (Eigen::Index k = 0; k < one.cols(); ++k) all.add(one.col(k) - from * one.col(0));
  return all.result();
}

}  // namespace

Errors errors(const Recording& run, const Recording& reference) {
  return {deviation(run.tip, run.h, reference.tip, reference.h),
          deviation(run.base_force, run.h, reference.base_force, reference.h), deviation(run.probes, reference.probes)};
}

Errors magnitudes(const Recording& reference) {
  return {magnitude(reference.tip, 1), magnitude(reference.base_force, 0), magnitude(reference.probes, 0)};
}

}  // namespace acus
