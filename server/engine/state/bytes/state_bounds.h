// SPDX-License-Identifier: GPL-3.0-or-later
// How large the numbers of a state can be that came out of ticks: far beyond what any tissue bears, and far below what
// would be felt as a blow that no tissue gives.
#pragma once

#include <stdexcept>
#include <string>

#include "server/engine/state/model.h"

namespace acus {

struct StateBounds {
  double way;    // m, of a node from where it rests
  double force;  // N, on a node or by a needle
  double y;      // (N m)^½, of L⁻¹ times forces
  double mode;   // m kg^½, of an amplitude

  explicit StateBounds(const Model& model);
};

inline void require_in_range(bool holds, const std::string& what) {
  if (!holds) throw std::runtime_error(what + " is out of range");
}

// Whether no number of a vector or matrix is larger.
template <class Numbers>
bool within(const Numbers& numbers, double most) {
  return numbers.size() == 0 || numbers.cwiseAbs().maxCoeff() <= most;
}

}  // namespace acus
