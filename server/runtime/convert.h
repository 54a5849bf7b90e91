// SPDX-License-Identifier: GPL-3.0-or-later
// The simulation's types as the protocol's and back.
#pragma once

#include "protocol/messages.h"
#include "server/math/types.h"
#include "server/simulation/report.h"

namespace acus {

inline protocol::Vector3 to_wire(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
inline protocol::Quaternion to_wire(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline Vector3 from_wire(const protocol::Vector3& v) { return {v[0], v[1], v[2]}; }
inline Quaternion from_wire(const protocol::Quaternion& q) { return {q.w, q.x, q.y, q.z}; }

// Points (3 x n) as x, y, z of one after the other; `packed` holds 3 n numbers already.
template <class Number>
void pack(const Eigen::Ref<const Matrix3X>& points, std::vector<Number>& packed) {
  Eigen::Map<Eigen::Matrix<Number, 3, Eigen::Dynamic>>(packed.data(), 3, points.cols()) = points.cast<Number>();
}

}  // namespace acus
