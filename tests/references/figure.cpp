// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/references/figure.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace acus {

bool agrees(const std::string& what, double reference, double measured, double tolerance) {
  static const bool printing = std::getenv("ACUS_FIGURES") != nullptr;
  if (printing) std::printf("%s | %.8g | %.8g | %.2g\n", what.c_str(), reference, measured, tolerance);
  return std::abs(measured - reference) <= tolerance;
}

double observed_order(double coarse_error, double fine_error, double ratio) {
  return std::log(coarse_error / fine_error) / std::log(ratio);
}

}  // namespace acus
