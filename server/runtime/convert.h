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

// Enumerations that both sides number alike, so that one is the other's value.
static_assert(static_cast<int>(Phase::free) == static_cast<int>(protocol::Phase::free));
static_assert(static_cast<int>(Phase::contact) == static_cast<int>(protocol::Phase::contact));
static_assert(static_cast<int>(Phase::inside) == static_cast<int>(protocol::Phase::inside));
static_assert(static_cast<int>(Phase::through) == static_cast<int>(protocol::Phase::through));
static_assert(static_cast<int>(EventKind::contact) == static_cast<int>(protocol::EventKind::contact));
static_assert(static_cast<int>(EventKind::release) == static_cast<int>(protocol::EventKind::release));
static_assert(static_cast<int>(EventKind::puncture) == static_cast<int>(protocol::EventKind::puncture));
static_assert(static_cast<int>(EventKind::crossing) == static_cast<int>(protocol::EventKind::crossing));
static_assert(static_cast<int>(EventKind::reentry) == static_cast<int>(protocol::EventKind::reentry));
static_assert(static_cast<int>(EventKind::exit) == static_cast<int>(protocol::EventKind::exit));
static_assert(static_cast<int>(EventKind::withdrawal) == static_cast<int>(protocol::EventKind::withdrawal));
static_assert(static_cast<int>(kLawsNotConverged) == static_cast<int>(protocol::kLawsNotConverged));
static_assert(static_cast<int>(kNewtonNotConverged) == static_cast<int>(protocol::kNewtonNotConverged));
static_assert(static_cast<int>(kTangentProjected) == static_cast<int>(protocol::kTangentProjected));
static_assert(static_cast<int>(kRowsDropped) == static_cast<int>(protocol::kRowsDropped));
static_assert(static_cast<int>(kPathFull) == static_cast<int>(protocol::kPathFull));
static_assert(static_cast<int>(kNotFinite) == static_cast<int>(protocol::kNotFinite));
static_assert(static_cast<int>(kSolverFellBack) == static_cast<int>(protocol::kSolverFellBack));
static_assert(static_cast<int>(kSweepsCapped) == static_cast<int>(protocol::kSweepsCapped));
static_assert(static_cast<int>(kIterationsCapped) == static_cast<int>(protocol::kIterationsCapped));
static_assert(static_cast<int>(kPublishingReduced) == static_cast<int>(protocol::kPublishingReduced));
static_assert(static_cast<int>(kStepLimited) == static_cast<int>(protocol::kStepLimited));
static_assert(static_cast<int>(kElementsInverted) == static_cast<int>(protocol::kElementsInverted));
static_assert(static_cast<int>(LawMethod::gauss_seidel) == static_cast<int>(protocol::LawSolver::gauss_seidel));
static_assert(static_cast<int>(LawMethod::direct) == static_cast<int>(protocol::LawSolver::direct));

// What a message may command is what the simulation takes.
static_assert(kMaxPosition == protocol::kMaxPosition);
static_assert(kMaxSpin == protocol::kMaxSpin);

inline protocol::Phase to_wire(Phase phase) { return static_cast<protocol::Phase>(phase); }
inline protocol::LawSolver to_wire(LawMethod method) { return static_cast<protocol::LawSolver>(method); }
inline protocol::EventKind to_wire(EventKind kind) { return static_cast<protocol::EventKind>(kind); }

}  // namespace acus
