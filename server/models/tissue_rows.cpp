// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/models/tissue_rows.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace acus {

TissueRows::TissueRows(const SparseCholesky& factor, int max_rows, int max_nodes)
    : corridor_(factor, std::min(max_nodes, factor.size() / 3)) {
  const int slots = corridor_.capacity();
  rows_.resize(static_cast<std::size_t>(max_rows));
  gram_rows_.setZero(3 * slots, max_rows);
  gram_columns_.setZero(max_rows, 3 * slots);
  slot_displacement_.setZero(3, slots);
  slot_read_.resize(static_cast<std::size_t>(slots));
  slot_forces_.setZero(3 * slots);
  touched_.reserve(static_cast<std::size_t>(slots));
}

void TissueRows::begin() {
  assert(count_ < static_cast<int>(rows_.size()));
  rows_[count_].parts = 0;
}

bool TissueRows::add_force(int free_node, const Vector3& force) {
  const int slot = corridor_.slot(free_node);
  if (slot < 0) return false;
  Row& row = rows_[count_];
  assert(row.parts < kMaxParts);
  row.slot[row.parts] = slot;
  row.force[row.parts++] = force;
  return true;
}

// G S first, by rows; turned round, so that all rows that come after one are contiguous, W_t takes one pass over them for
// each of the few slots that the row acts on. Slots before the first and behind the last that a row acts on are left
// alone: what other paths have left behind.
void TissueRows::add_compliance(const VectorX& y, Eigen::Ref<MatrixX> W, std::span<double> delta) {
  const int n = count_;
  int first = corridor_.used(), last = -1;
  for (int r = 0; r < n; ++r)
    for (int k = 0; k < rows_[r].parts; ++k) {
      first = std::min(first, rows_[r].slot[k]);
      last = std::max(last, rows_[r].slot[k]);
    }
  if (last < 0) return;
  const int dofs = 3 * (last - first + 1);
  std::fill(slot_read_.begin() + first, slot_read_.begin() + last + 1, 0);
  for (int r = 0; r < n; ++r) {
    const Row& row = rows_[r];
    auto column = gram_rows_.col(r).head(dofs);
    column.setZero();
    for (int k = 0; k < row.parts; ++k) {
      const int slot = row.slot[k];
      const Vector3& f = row.force[k];
      const auto gram = corridor_.gram().block(3 * first, 3 * slot, dofs, 3);
      column += f[0] * gram.col(0) + f[1] * gram.col(1) + f[2] * gram.col(2);
      if (std::exchange(slot_read_[slot], 1) == 0) slot_displacement_.col(slot) = corridor_.free_displacement(slot, y);
      delta[r] += f.dot(slot_displacement_.col(slot));
    }
  }
  gram_columns_.topLeftCorner(n, dofs) = gram_rows_.topLeftCorner(dofs, n).transpose();
  for (int r = 0; r < n; ++r) {
    auto below = W.col(r).segment(r, n - r);
    for (int k = 0; k < rows_[r].parts; ++k) {
      const Vector3& f = rows_[r].force[k];
      const auto columns = gram_columns_.block(r, 3 * (rows_[r].slot[k] - first), n - r, 3);
      below += f[0] * columns.col(0) + f[1] * columns.col(1) + f[2] * columns.col(2);
    }
  }
}

// Slots in the order in which the rows touch them: sums do not depend on which slot a node was given.
void TissueRows::add_forces(std::span<const double> lambda, VectorX& y) {
  touched_.clear();
  std::fill(slot_read_.begin(), slot_read_.end(), 0);
  for (int r = 0; r < count_; ++r)
    for (int k = 0; k < rows_[r].parts; ++k) {
      const int slot = rows_[r].slot[k];
      auto force = slot_forces_.segment<3>(3 * slot);
      if (std::exchange(slot_read_[slot], 1) == 0) {
        touched_.push_back(slot);
        force.setZero();
      }
      force += lambda[r] * rows_[r].force[k];
    }
  for (const int slot : touched_) {
    const Vector3 force = slot_forces_.segment<3>(3 * slot);
    if (!force.isZero(0)) corridor_.add_force(slot, force, y);
  }
}

}  // namespace acus
