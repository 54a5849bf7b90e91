// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/tissue_rows.h"

#include <algorithm>
#include <cassert>

namespace acus {

TissueRows::TissueRows(const SparseCholesky& factor, int max_rows, int max_nodes, const ModeShapes* stiffened)
    : corridor_(factor, std::min(max_nodes, factor.size() / 3), stiffened) {
  const auto rows = static_cast<std::size_t>(max_rows), slots = static_cast<std::size_t>(corridor_.capacity());
  const std::size_t parts = 8 * rows + 3 * static_cast<std::size_t>(max_nodes);
  open_.reserve(slots);
  blocks_.reserve(rows);
  slots_.reserve(parts);
  forces_.reserve(3 * parts);
  slot_displacement_.setZero(3, corridor_.capacity());
  place_.assign(slots, -1);
  touched_.reserve(slots);
  places_.resize(parts);
  moved_.resize(3 * slots);
  slot_forces_.setZero(3 * corridor_.capacity());
}

void TissueRows::clear() {
  count_ = 0;
  blocks_.clear();
  slots_.clear();
  forces_.clear();
}

void TissueRows::begin() { open_.clear(); }

bool TissueRows::add_force(int free_node, const Vector3& force) {
  const int slot = corridor_.slot(free_node);
  if (slot < 0) return false;
  for (Part& part : open_)
    if (part.slot == slot) return part.force += force, true;
  if (slots_.size() + open_.size() == slots_.capacity()) return false;
  open_.push_back({slot, force});
  return true;
}

bool TissueRows::fits_last_block() const {
  if (blocks_.empty() || blocks_.back().rows == kBlockRows) return false;
  return std::ranges::equal(slots(blocks_.back()), open_, {}, {}, &Part::slot);
}

int TissueRows::end() {
  assert(blocks_.size() < blocks_.capacity());
  if (!fits_last_block()) {
    const int begin = static_cast<int>(slots_.size());
    for (const Part& part : open_) slots_.push_back(part.slot);
    forces_.resize(3 * slots_.size(), Four::Zero());
    blocks_.push_back({count_, 0, begin, static_cast<int>(slots_.size())});
  }
  Block& block = blocks_.back();
  Four* numbers = forces_.data() + 3 * block.begin;
  for (const Part& part : open_)
    for (int a = 0; a < 3; ++a) (*numbers++)[block.rows] = part.force[a];
  ++block.rows;
  return count_++;
}

bool TissueRows::meet(int slot) {
  if (place_[slot] >= 0) return false;
  place_[slot] = static_cast<int>(touched_.size());
  touched_.push_back(slot);
  return true;
}

void TissueRows::forget_met() {
  for (const int slot : touched_) place_[slot] = -1;
  touched_.clear();
}

void TissueRows::read_displacements(const VectorX& y) {
  forget_met();
  for (const int slot : slots_)
    if (meet(slot)) slot_displacement_.col(slot) = corridor_.free_displacement(slot, y);
}

// G S of a block, at the slots met so far.
void TissueRows::multiply_by_gram(const Block& block) {
  const Eigen::Index stride = corridor_.gram().rows();
  const double* gram = corridor_.gram().data();
  Four* moved = moved_.data();
  for (const int at : touched_) {
    Four sum[3] = {Four::Zero(), Four::Zero(), Four::Zero()};
    const Four* f = forces(block);
    for (const int slot : slots(block)) {
      const double* column = gram + 3 * at + 3 * slot * stride;
      for (int b = 0; b < 3; ++b, column += stride, ++f)
        for (int a = 0; a < 3; ++a) sum[a] += column[a] * *f;
    }
    for (int a = 0; a < 3; ++a) *moved++ = sum[a];
  }
}

// For a block to come.
void TissueRows::fetch_gram(const Block& block) const {
  constexpr Eigen::Index kLine = 64 / sizeof(double);
  const auto [first, last] = std::ranges::minmax(touched_);
  for (const int slot : slots(block))
    for (int b = 0; b < 3; ++b) {
      const double* column = corridor_.gram().col(3 * slot + b).data();
      for (const double *at = column + 3 * first, *end = column + 3 * (last + 1); at < end; at += kLine)
        __builtin_prefetch(at);
    }
}

// The rows of `later` in the columns of `block`, whose G S moved_ is; `column` is the first of them, at the first row.
void TissueRows::set_block(const Block& block, const Block& later, double* column, Eigen::Index stride) const {
  Four columns[kBlockRows] = {Four::Zero(), Four::Zero(), Four::Zero(), Four::Zero()};
  const Four* f = forces(later);
  for (int k = later.begin; k < later.end; ++k) {
    const Four* moved = moved_.data() + 3 * places_[k];
    for (int a = 0; a < 3; ++a, ++f)
      for (int c = 0; c < kBlockRows; ++c) columns[c] += moved[a][c] * *f;
  }
  for (int c = 0; c < block.rows; ++c, column += stride) {
    if (&block != &later && later.rows == kBlockRows)
      Four::Map(column) = columns[c];
    else
      for (int r = &block == &later ? c : 0; r < later.rows; ++r) column[r] = columns[c][r];
  }
}

void TissueRows::set_compliance(Eigen::Ref<MatrixX> W, std::span<double> delta) {
  forget_met();
  for (auto block = blocks_.rbegin(); block != blocks_.rend(); ++block) {
    Four free = Four::Zero();
    const Four* f = forces(*block);
    for (int k = block->begin; k < block->end; ++k, f += 3) {
      const int slot = slots_[k];
      meet(slot);
      places_[k] = place_[slot];
      for (int a = 0; a < 3; ++a) free += slot_displacement_(a, slot) * f[a];
    }
    for (int r = 0; r < block->rows; ++r) delta[block->first_row + r] += free[r];
    multiply_by_gram(*block);
    if (const auto next = block + 1; next != blocks_.rend() && !touched_.empty()) fetch_gram(*next);
    double* column = W.col(block->first_row).data();
    for (auto later = block.base() - 1; later != blocks_.end(); ++later)
      set_block(*block, *later, column + later->first_row, W.outerStride());
  }
}

void TissueRows::gather_forces(std::span<const double> lambda) {
  forget_met();
  for (const Block& block : blocks_) {
    Four own = Four::Zero();
    for (int r = 0; r < block.rows; ++r) own[r] = lambda[block.first_row + r];
    const Four* f = forces(block);
    for (const int slot : slots(block)) {
      auto force = slot_forces_.segment<3>(3 * slot);
      if (meet(slot)) force.setZero();
      for (int a = 0; a < 3; ++a) force[a] += (own * *f++).sum();
    }
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
