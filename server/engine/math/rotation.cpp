// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/math/rotation.h"

namespace acus {

Quaternion rotation_between(const Vector3& from, const Vector3& to) {
  assert(from.squaredNorm() > 0 && to.squaredNorm() > 0);
  return Quaternion::FromTwoVectors(from, to);
}

}  // namespace acus
