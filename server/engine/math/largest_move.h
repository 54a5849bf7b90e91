// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "server/engine/math/types.h"

namespace acus {

// The longest way of a node from one configuration to another (3 x nodes, m), 0 without nodes.
inline double largest_move(const Matrix3X& from, const Matrix3X& to) {
  return from.cols() == 0 ? 0 : (to - from).colwise().norm().maxCoeff();
}

}  // namespace acus
