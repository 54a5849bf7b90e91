// SPDX-License-Identifier: GPL-3.0-or-later
// The numbers of a supernodal Cholesky factor, packed in the order in which substitutions read them.
//
// A panel is cut into strips of at most kStripColumns columns. A strip is its triangle T, then the rows below it in
// tiles of kTileRows rows, column by column, eight numbers each (lanes.h), filled up with zeros. The rows below are the
// panel's: first those of its later columns. T is kept as its inverse, which has no chain of divisions to wait for, by
// columns and once more by rows: forward solves x = T⁻¹ w, then w_below -= tiles x; backward mirrors it.
//
// Kept as float, L takes half the memory traffic of double, which is what a substitution costs, in half precision a
// quarter, times a power of two that suits its range. Sums are in double, so that all substitutions are those of one
// and the same matrix: that of L as rounded, off by 6e-8 of |L||L|ᵀ, in half precision by 5e-4.
#pragma once

#include <cstddef>

#include "server/engine/math/factor/panel_kernel.h"
#include "server/engine/math/factor/panel_tree.h"
#include "server/engine/math/lanes.h"
#include "server/engine/math/types.h"

namespace acus {

// Numbers that are kept of a factor, padding included.
std::size_t kept_entries(const PanelTree& tree);

template <class Real>
class PanelValues {
 public:
  // The columns of panel s stand at x + start[s], one after the other, each with all of the panel's rows.
  void pack(const PanelTree& tree, const double* x, const int* start);

  // w <- L⁻¹ w on the rows of panel s: its columns are solved for and taken out of the rows below. One
  // right-hand side, or three that stand `stride` apart; each has kTileRows entries to spare behind the panel's rows.
  // Parts of a panel, whole strips, do that with columns `first` to `last` - 1: forward one after the other.
  void forward(const PanelTree& tree, int s, int first, int last, double* w) const;
  void forward_three(const PanelTree& tree, int s, int first, int last, double* w, std::ptrdiff_t stride) const;

  // w <- L⁻ᵀ w likewise, from the rows below to the columns, the last part first; the spare entries must be zero.
  void backward(const PanelTree& tree, int s, int first, int last, double* w) const;

  std::size_t bytes() const { return values_.size() * sizeof(Real); }

 private:
  const Real* panel(int s) const { return values_.data() + start_[static_cast<std::size_t>(s)]; }

  std::vector<Real, Eigen::aligned_allocator<Real>> values_;
  std::vector<std::ptrdiff_t> start_;  // per panel, into values_; the end behind the last
  PanelScale scale_;
};

extern template class PanelValues<float>;
extern template class PanelValues<double>;
extern template class PanelValues<Float16>;

}  // namespace acus
