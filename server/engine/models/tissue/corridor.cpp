// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/corridor.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

namespace acus {

namespace {

// Entries of the factor that three substitutions go through while one of the columns is multiplied with another's.
constexpr double kProductEntry = 1.5;

}  // namespace

Corridor::Corridor(const SparseCholesky& factor, int capacity, const ModeShapes* stiffened)
    : factor_(factor), stiffened_(stiffened), panel_rows_(factor.make_panel_rows()) {
  next_.panel_rows = panel_rows_;
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
  next_.slot = -1;
}

int Corridor::take_slot() {
  if (used_ < capacity()) return used_++;
  const auto oldest = std::min_element(slots_.begin(), slots_.end(),
                                       [](const Slot& a, const Slot& b) { return a.last_use < b.last_use; });
  const int slot = static_cast<int>(oldest - slots_.begin());
  // What is made ahead must not be what there is no room for.
  if (oldest->last_use == use_) return std::exchange(next_.slot, -1);
  if (slot == next_.slot) next_.slot = -1;
  return slot;
}

void Corridor::give_slot(int s, int node) {
  if (slots_[s].node >= 0) slot_of_node_[slots_[s].node] = -1;
  slots_[s] = {node, factor_.tree().panel_of[factor_.position(3 * node)], use_};
  slot_of_node_[node] = s;
}

// G of two slots; what that costs, in entries.
double Corridor::multiply(int s, int other) {
  Matrix3 block = product(other, s);
  if (stiffened_ != nullptr) block -= stiffening(other, s);
  gram_.block<3, 3>(3 * other, 3 * s) = block;
  gram_.block<3, 3>(3 * s, 3 * other) = block.transpose();
  return kProductEntry * factor_.tree().panels[slots_[s].panel].to_root;
}

void Corridor::fill(int s) {
  factor_.unit_columns(factor_.position(3 * slots_[s].node), columns_[s], panel_rows_);
  for (int other = 0; other < used_; ++other)
    if (has_columns(other)) multiply(s, other);
}

double Corridor::go_on(double entries) {
  const int s = next_.slot;
  slots_[s].last_use = use_;
  factor_.go_on(next_.at, entries, columns_[s], next_.panel_rows);
  for (; next_.at.panel < 0 && next_.multiplied < used_ && entries > 0; ++next_.multiplied)
    entries -= multiply(s, next_.multiplied);
  if (next_.at.panel < 0 && next_.multiplied == used_) next_.slot = -1;
  return entries;
}

bool Corridor::make_ahead(int node) {
  if (next_.slot < 0) {
    if (slot_of_node_[node] >= 0) return slots_[slot_of_node_[node]].last_use = use_, false;
    const int s = take_slot();
    if (s < 0) return false;
    give_slot(s, node);
    next_.slot = s;
    next_.at = factor_.begin_unit_columns(factor_.position(3 * node), columns_[s]);
    next_.multiplied = 0;
  }
  if (ahead_ > 0) ahead_ = go_on(ahead_);
  return true;
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
    give_slot(s, node);
    fill(s);
  }
  if (s == next_.slot) go_on(std::numeric_limits<double>::infinity());
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
