// SPDX-License-Identifier: GPL-3.0-or-later
// The laws without their bilateral rows. Those, B, hold at every answer and so can be eliminated; what is left over for
// the others, I, is a system of the same kind. About an iterate (lambda, delta), delta = W lambda + delta_free,
//
//   S = W_II - W_IB W_BB⁻¹ W_BI                             W_BB with the compliances s of soft rows on its diagonal
//   delta_I = S lambda_I' + delta_bar,   delta_bar = delta_I - W_IB W_BB⁻¹ (delta_B + s lambda_B) - S lambda_I
//   lambda_B' = lambda_B - W_BB⁻¹ (delta_B + s lambda_B + W_BI (lambda_I' - lambda_I)).
//
// A stiff needle couples the bilateral rows of neighbouring points so tightly that sweeping over them needs hundreds of
// sweeps, and more with every point (200 left millinewtons at a spacing of 4 mm); the remaining rows are few and nearly
// independent.
//
// Points closer than mesh and beams can tell apart make W_BB nearly singular: kRegularization of its mean diagonal is
// added, a hundred times more as long as that does not factorise. Started at lambda = 0 and repeated about its own
// answer, the elimination is the proximal point method [Rockafellar 1976], which converges to the answer on W itself;
// rounding errors of the factor are mended on the way. The scales of the others stay those of the full W, so a
// violation is the same number here and there, but for cones, whose own blocks are those of S.
#pragma once

#include <vector>

#include "server/engine/laws/solver/law_system.h"

namespace acus {

class ReducedLaws {
 public:
  static constexpr double kRegularization = 1e-12;

  // `room`: rows² numbers at least in every call, from reduce() to the last of its system. It must outlive this.
  ReducedLaws(int capacity, std::span<double> room);

  // Splits the rows and factorises; false if W_BB cannot be made positive definite, or numbers of S are not finite.
  bool reduce(const LawSystem& full);

  // What of the room the system at hand leaves.
  std::span<double> room_behind() const {
    const auto rows = static_cast<std::size_t>(bilateral_count_ + other_count_);
    return room_.subspan(rows * rows);
  }

  // Moves the reduced system to an iterate of the full one.
  void linearize(const LawState& iterate);

  // The others in their own numbering; valid after linearize().
  LawSystem system() const;
  LawState others() { return {{lambda_.data(), others_.size()}, {delta_.data(), others_.size()}}; }

  // Copies the others' forces out of, or into, those of all rows.
  void gather(std::span<const double> lambda);
  // And lets the bilateral rows follow; delta is not touched.
  void expand(std::span<double> lambda);

 private:
  void split(const LawSystem& full);
  bool factorize(const LawSystem& full);
  // Lower triangle: L of W_BB and below it W_IB L⁻ᵀ; S in full in the last corner. Packed, so that it stays in the
  // caches.
  auto factor() {
    return Eigen::Map<MatrixX>(room_.data(), bilateral_count_ + other_count_, bilateral_count_ + other_count_);
  }
  auto factor() const {
    return Eigen::Map<const MatrixX>(room_.data(), bilateral_count_ + other_count_, bilateral_count_ + other_count_);
  }

  std::vector<int> order_;              // rows of W: the bilateral ones, then the others
  std::vector<int> others_;             // rows of W
  std::vector<int> place_;              // row of W -> index in others_
  std::vector<Law> laws_;               // of the others, normal_row in their own numbering
  std::vector<double> scale_;           // of the others
  std::vector<double> lambda_, delta_;  // of the others
  Eigen::Index bilateral_count_ = 0, other_count_ = 0;
  std::span<double> room_;  // of factor()
  VectorX softness_;        // s (m/N)
  VectorX y_;               // L⁻¹ (delta_B + s lambda_B)
  VectorX delta_free_;      // delta_bar
  VectorX step_;            // scratch: change of lambda_I, then of lambda_B
};

}  // namespace acus
