// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/corridor.h"

#include <algorithm>
#include <cassert>

namespace acus {

Corridor::Corridor(const SparseCholesky& factor, int capacity, const ModeShapes* stiffened)
    : factor_(factor), stiffened_(stiffened), panel_rows_(factor.make_panel_rows()) {
  slots_.resize(static_cast<std::size_t>(capacity));
  slot_of_node_.assign(static_cast<std::size_t>(factor.size() / 3), -1);
  columns_.assign(slots_.size(), Eigen::MatrixX3d::Zero(factor.tree().longest_way, 3));
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

void Corridor::fill(int s, int node) {
  const int position = factor_.position(3 * node);
  factor_.unit_columns(position, columns_[s], panel_rows_);
  slots_[s] = {node, factor_.tree().panel_of[position], use_};
  slot_of_node_[node] = s;
  for (int other = 0; other < used_; ++other) {
    Matrix3 block = product(other, s);
    if (stiffened_ != nullptr) block -= stiffening(other, s);
    gram_.block<3, 3>(3 * other, 3 * s) = block;
    gram_.block<3, 3>(3 * s, 3 * other) = block.transpose();
  }
}

// Psi_a Psi_bᵀ, the transpose of Psi_b Psi_aᵀ to the bit.
Matrix3 Corridor::stiffening(int a, int b) const {
  const float* rows_a = stiffened_->row(factor_.position(3 * slots_[a].node)).data();
  const float* rows_b = stiffened_->row(factor_.position(3 * slots_[b].node)).data();
  const Eigen::Index modes = stiffened_->cols();
  Matrix3 block = Matrix3::Zero();
  for (Eigen::Index k = 0; k < modes; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i)
        block(i, j) += static_cast<double>(rows_a[i * modes + k]) * static_cast<double>(rows_b[j * modes + k]);
  return block;
}

// Y_aᵀ Y_b: the two ways have their ends in common, from the panel on where they meet.
Matrix3 Corridor::product(int a, int b) const {
  const PanelTree& tree = factor_.tree();
  const int meeting = tree.meeting(slots_[a].panel, slots_[b].panel);
  if (meeting < 0) return Matrix3::Zero();
  const int common = tree.panels[meeting].to_root;
  const double* ya = columns_[a].data() + tree.panels[slots_[a].panel].to_root - common;
  const double* yb = columns_[b].data() + tree.panels[slots_[b].panel].to_root - common;
  const Eigen::Index stride = columns_[a].rows();
  Matrix3 sum;
  for (int j = 0; j < 3; ++j) {
    const double* column = yb + j * stride;
    double s0 = 0, s1 = 0, s2 = 0;
#pragma omp simd reduction(+ : s0, s1, s2)
    for (int i = 0; i < common; ++i) {
      s0 += ya[i] * column[i];
      s1 += ya[i + stride] * column[i];
      s2 += ya[i + 2 * stride] * column[i];
    }
    sum.col(j) << s0, s1, s2;
  }
  return sum;
}

int Corridor::slot(int node) {
  assert(node >= 0 && node < static_cast<int>(slot_of_node_.size()));
  int s = slot_of_node_[node];
  if (s < 0) {
    s = take_slot();
    if (s < 0) return -1;
    fill(s, node);
  }
  slots_[s].last_use = use_;
  return s;
}

Vector3 Corridor::free_displacement(int s, const VectorX& y) const {
  assert(s >= 0 && s < used_ && y.size() == factor_.size());
  const PanelTree& tree = factor_.tree();
  const double* column = columns_[s].data();
  const Eigen::Index stride = columns_[s].rows();
  double s0 = 0, s1 = 0, s2 = 0;
  for (int p = slots_[s].panel; p >= 0; p = tree.panels[p].parent) {
    const double* part = y.data() + tree.panels[p].first;
    const int count = tree.panels[p].columns;
#pragma omp simd reduction(+ : s0, s1, s2)
    for (int i = 0; i < count; ++i) {
      s0 += column[i] * part[i];
      s1 += column[i + stride] * part[i];
      s2 += column[i + 2 * stride] * part[i];
    }
    column += count;
  }
  return {s0, s1, s2};
}

void Corridor::add_force(int s, const Vector3& force, VectorX& y) const {
  assert(s >= 0 && s < used_ && y.size() == factor_.size());
  const PanelTree& tree = factor_.tree();
  const double* column = columns_[s].data();
  const Eigen::Index stride = columns_[s].rows();
  for (int p = slots_[s].panel; p >= 0; p = tree.panels[p].parent) {
    double* part = y.data() + tree.panels[p].first;
    const int count = tree.panels[p].columns;
    for (int i = 0; i < count; ++i)
      part[i] += (force[0] * column[i] + force[1] * column[i + stride]) + force[2] * column[i + 2 * stride];
    column += count;
  }
}

}  // namespace acus
