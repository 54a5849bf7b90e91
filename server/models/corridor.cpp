// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/models/corridor.h"

#include <algorithm>

namespace acus {

Corridor::Corridor(int nodes, int capacity) {
  slots_.resize(static_cast<std::size_t>(capacity));
  slot_of_node_.assign(static_cast<std::size_t>(nodes), -1);
  columns_.assign(slots_.size(), Eigen::MatrixX3d::Zero(3 * nodes, 3));
  gram_.setZero(3 * capacity, 3 * capacity);
}

void Corridor::clear() {
  for (int s = 0; s < used_; ++s) {
    slot_of_node_[slots_[s].node] = -1;
    slots_[s] = Slot{};
  }
  used_ = 0;
}

int Corridor::take_slot() {
  if (used_ < capacity()) return used_++;
  const auto oldest = std::min_element(slots_.begin(), slots_.end(),
                                       [](const Slot& a, const Slot& b) { return a.last_use < b.last_use; });
  if (oldest->last_use == use_) return -1;
  slot_of_node_[oldest->node] = -1;
  return static_cast<int>(oldest - slots_.begin());
}

void Corridor::fill(const SparseCholesky& factor, int s, int node) {
  Eigen::MatrixX3d& columns = columns_[s];
  columns.setZero();
  int first = factor.size();
  for (int k = 0; k < 3; ++k) {
    const int row = factor.position(3 * node + k);
    columns(row, k) = 1;
    first = std::min(first, row);
  }
  factor.forward3(columns, first);
  slots_[s] = {node, first, use_};
  slot_of_node_[node] = s;

  for (int other = 0; other < used_; ++other) {
    const Eigen::Index tail = factor.size() - std::max(first, slots_[other].first);
    const Matrix3 block = columns_[other].bottomRows(tail).transpose().lazyProduct(columns.bottomRows(tail));
    gram_.block<3, 3>(3 * other, 3 * s) = block;
    gram_.block<3, 3>(3 * s, 3 * other) = block.transpose();
  }
}

int Corridor::slot(const SparseCholesky& factor, int node) {
  int s = slot_of_node_[node];
  if (s < 0) {
    s = take_slot();
    if (s < 0) return -1;
    fill(factor, s, node);
  }
  slots_[s].last_use = use_;
  return s;
}

Vector3 Corridor::free_displacement(int s, const VectorX& y) const {
  const Eigen::Index tail = y.size() - slots_[s].first;
  return columns_[s].bottomRows(tail).transpose().lazyProduct(y.tail(tail));
}

void Corridor::add_force(int s, const Vector3& force, VectorX& y) const {
  const Eigen::Index tail = y.size() - slots_[s].first;
  const auto& c = columns_[s];
  y.tail(tail) += force[0] * c.col(0).tail(tail) + force[1] * c.col(1).tail(tail) + force[2] * c.col(2).tail(tail);
}

}  // namespace acus
