// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue_rows.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace acus {

TissueRows::TissueRows(const SparseCholesky& factor, int max_rows, int max_nodes, const ModeShapes* stiffened)
    : corridor_(factor, std::min(max_nodes, factor.size() / 3), stiffened) {
  const int slots = corridor_.capacity();
  ends_.resize(static_cast<std::size_t>(max_rows) + 1);
  parts_.reserve(static_cast<std::size_t>(8 * max_rows + 3 * max_nodes));
  gram_rows_.setZero(3 * slots, max_rows);
  gram_columns_.setZero(max_rows, 3 * slots);
  slot_displacement_.setZero(3, slots);
  slot_read_.resize(static_cast<std::size_t>(slots));
  slot_forces_.setZero(3 * slots);
  touched_.reserve(static_cast<std::size_t>(slots));
}

void TissueRows::begin() {
  assert(count_ + 1 < static_cast<int>(ends_.size()));
  parts_.erase(parts_.begin() + ends_[count_], parts_.end());
}

bool TissueRows::add_force(int free_node, const Vector3& force) {
  const int slot = corridor_.slot(free_node);
  if (slot < 0) return false;
  for (auto part = parts_.begin() + ends_[count_]; part != parts_.end(); ++part)
    if (part->slot == slot) return part->force += force, true;
  if (parts_.size() == parts_.capacity()) return false;
  parts_.push_back({slot, force});
  return true;
}

int TissueRows::end() {
  ends_[count_ + 1] = static_cast<int>(parts_.size());
  return count_++;
}

void TissueRows::read_displacements(const VectorX& y) {
  std::fill(slot_read_.begin(), slot_read_.begin() + corridor_.used(), 0);
  for (int r = 0; r < count_; ++r)
    for (const Part& part : parts(r))
      if (std::exchange(slot_read_[part.slot], 1) == 0)
        slot_displacement_.col(part.slot) = corridor_.free_displacement(part.slot, y);
}

// G S first, by rows; turned round, so that all rows that come after one are contiguous, W_t takes one pass over them for
// each of the few slots that the row acts on. Slots before the first and behind the last that a row acts on are left
// alone: what other paths have left behind.
void TissueRows::add_compliance(Eigen::Ref<MatrixX> W, std::span<double> delta) {
  const int n = count_;
  int first = corridor_.used(), last = -1;
  for (int r = 0; r < n; ++r)
    for (const Part& part : parts(r)) {
      first = std::min(first, part.slot);
      last = std::max(last, part.slot);
    }
  if (last < 0) return;
  const int dofs = 3 * (last - first + 1);
  for (int r = 0; r < n; ++r) {
    auto column = gram_rows_.col(r).head(dofs);
    column.setZero();
    for (const auto& [slot, f] : parts(r)) {
      const auto gram = corridor_.gram().block(3 * first, 3 * slot, dofs, 3);
      column += f[0] * gram.col(0) + f[1] * gram.col(1) + f[2] * gram.col(2);
      delta[r] += f.dot(slot_displacement_.col(slot));
    }
  }
  gram_columns_.topLeftCorner(n, dofs) = gram_rows_.topLeftCorner(dofs, n).transpose();
  for (int r = 0; r < n; ++r) {
    auto below = W.col(r).segment(r, n - r);
    for (const auto& [slot, f] : parts(r)) {
      const auto columns = gram_columns_.block(r, 3 * (slot - first), n - r, 3);
      below += f[0] * columns.col(0) + f[1] * columns.col(1) + f[2] * columns.col(2);
    }
  }
}

void TissueRows::gather_forces(std::span<const double> lambda) {
  touched_.clear();
  std::fill(slot_read_.begin(), slot_read_.end(), 0);
  for (int r = 0; r < count_; ++r)
    for (const Part& part : parts(r)) {
      const int slot = part.slot;
      auto force = slot_forces_.segment<3>(3 * slot);
      if (std::exchange(slot_read_[slot], 1) == 0) {
        touched_.push_back(slot);
        force.setZero();
      }
      force += lambda[r] * part.force;
    }
}

void TissueRows::add_forces(std::span<const double> lambda, VectorX& y) {
  gather_forces(lambda);
  for (const int slot : touched_) {
    const Vector3 force = slot_forces_.segment<3>(3 * slot);
    if (!force.isZero(0)) corridor_.add_force(slot, force, y);
  }
}

}  // namespace acus
