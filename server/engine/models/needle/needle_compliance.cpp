// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/needle_compliance.h"

#include <algorithm>
#include <cassert>

namespace acus {

NeedleCompliance::NeedleCompliance(int beams, int max_rows) {
  order_.resize(static_cast<std::size_t>(max_rows));
  ends_.resize(static_cast<std::size_t>(beams) + 1);
  places_.resize(order_.size());
  panel_.setZero(max_rows, 12);
  column_.setZero(max_rows);
}

// Counting sort by falling beam; rows of one beam keep their order.
void NeedleCompliance::sort(std::span<const BeamRow> rows) {
  const auto rank = [this](const BeamRow& row) { return ends_.size() - 1 - static_cast<std::size_t>(row.beam); };
  std::fill(ends_.begin(), ends_.end(), 0);
  for (const BeamRow& row : rows) ++ends_[rank(row)];
  for (std::size_t k = 1; k < ends_.size(); ++k) ends_[k] += ends_[k - 1];
  for (std::size_t r = rows.size(); r-- > 0;) order_[--ends_[rank(rows[r])]] = static_cast<int>(r);
}

// The blocks of Z and the columns of all rows passed, from the nodes of the beam after to those of this one.
void NeedleCompliance::go_to_beam(const BlockTridiagonal& A, int beam) {
  const bool last = beam + 1 == A.blocks();
  z_far_ = last ? A.pivot_inverse(beam) : z_near_;
  auto far = panel_.topRightCorner(passed_, 6), near = panel_.topLeftCorner(passed_, 6);
  far = near;
  if (beam == 0) return;
  const Matrix6 transfer = A.transfer(beam - 1);
  z_beside_.noalias() = transfer * z_far_;
  z_near_ = A.pivot_inverse(beam - 1);
  z_near_.noalias() += z_beside_ * transfer.transpose();
  near = far.lazyProduct(transfer.transpose());
}

// Z Hᵀ of a row of this beam, and its compliance with all rows passed before and itself.
void NeedleCompliance::pass_row(const BeamRow& row) {
  Vector12 force = row.force;
  if (row.beam == 0) force.head<6>().setZero();  // the first node is held
  auto seen = panel_.row(passed_++);
  seen.tail<6>() = z_far_ * force.tail<6>();
  seen.head<6>().setZero();
  if (row.beam > 0) {
    seen.head<6>() = z_near_ * force.head<6>() + z_beside_ * force.tail<6>();
    seen.tail<6>() += z_beside_.transpose() * force.head<6>();
  }
  column_.head(passed_) = panel_.topRows(passed_).lazyProduct(force);
}

void NeedleCompliance::add_column(std::span<const int> places, Eigen::Ref<MatrixX> W) {
  const int place = places_[passed_ - 1] = places[order_[passed_ - 1]];
  double* below = W.col(place).data();
  for (int k = 0; k < passed_; ++k) {
    if (places_[k] >= place)
      below[places_[k]] += column_[k];
    else
      W(place, places_[k]) += column_[k];
  }
}

void NeedleCompliance::add_to(const BlockTridiagonal& A, std::span<const BeamRow> rows, std::span<const int> places,
                              Eigen::Ref<MatrixX> W) {
  assert(rows.size() == places.size() && rows.size() <= order_.size());
  assert(A.blocks() + 1 == static_cast<int>(ends_.size()));
  sort(rows);
  passed_ = 0;
  const int count = static_cast<int>(rows.size());
  for (int beam = A.blocks() - 1; passed_ < count; --beam) {
    go_to_beam(A, beam);
    while (passed_ < count && rows[order_[passed_]].beam == beam) {
      pass_row(rows[order_[passed_]]);
      add_column(places, W);
    }
  }
}

}  // namespace acus
