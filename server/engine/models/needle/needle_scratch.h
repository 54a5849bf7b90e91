// SPDX-License-Identifier: GPL-3.0-or-later
// What a tick needs of a needle besides its state: the configuration that is iterated, its linear system, its rows and
// the step. needle_linearization.h, needle_rows.h and needle_step.h work on it, in this order; from begin_needle() to
// commit_needle() it belongs to one tick.
#pragma once

#include <Eigen/Cholesky>
#include <optional>
#include <vector>

#include "server/engine/math/factor/block_tridiagonal.h"
#include "server/engine/math/types.h"
#include "server/engine/models/needle/held_base.h"
#include "server/engine/models/needle/needle.h"
#include "server/engine/models/needle/needle_compliance.h"

namespace acus {

struct NeedleConfiguration {
  NeedleShape shape;
  std::vector<Quaternion> q;  // per node

  Pose base() const { return {shape.x.col(0), q[0]}; }
};

struct NeedleScratch {
  NeedleScratch(const NeedleModel& model, double h, int max_rows);

  const NeedleShape& shape() const { return iterate.shape; }
  bool finite() const { return iterate.shape.x.allFinite() && reaction.allFinite() && dq.allFinite(); }

  double h;  // s

  NeedleConfiguration iterate;  // q_k
  NeedleConfiguration carried;  // q_0
  bool is_carried = true;       // q_k is still q_0
  NeedleConfiguration trial;    // at the end of a share of the step

  // The linear system.
  std::vector<Matrix12> material;           // K_m per beam at q_0
  Matrix6X g;                               // residual per node; of a rigid needle all of it in column 0
  Matrix6X trial_g;                         // likewise, at the trial
  BlockTridiagonal matrix;                  // nodes 1..n; of a rigid needle empty, like dq and dq_free
  Matrix6 base_coupling;                    // A(0, 1)
  Matrix6 base_diagonal = Matrix6::Zero();  // A(0, 0), inertia left out

  // A base on springs and dampers, if the needle has one.
  std::optional<HeldBase> held;
  MatrixX follow;                                        // F
  Eigen::LLT<Matrix6> base_factor{Matrix6::Identity()};  // of S + K
  Eigen::Matrix<double, Eigen::Dynamic, 6> base_rows;    // G, times the factor's inverse
  Vector6 base_free = Vector6::Zero();                   // u without the rows' forces
  Vector6 base_step = Vector6::Zero();                   // u

  // Rows and step.
  std::vector<BeamRow> rows;
  NeedleCompliance compliance;
  VectorX dq_free, dq;
  VectorX applied;                     // Hᵀ lambda on the free nodes
  Vector6 on_base = Vector6::Zero();   // Hᵀ lambda on node 0
  Vector6 reaction = Vector6::Zero();  // holder on needle at node 0 (N, N m, world), after move_needle()
};

}  // namespace acus
