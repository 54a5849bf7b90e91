// SPDX-License-Identifier: GPL-3.0-or-later
// How the wrench that a needle has for the hand at its base depends on where the base is: the tick's own linearisation.
//
// Had the base stood elsewhere at the end of the tick by d (translation, rotation vector; world, about the base), what
// the laws' lines delta = W lambda + delta_free say would be shifted by D d. With every law on the piece of its graph
// on which the tick found it, and T the combinations of rows whose force is not given by their piece,
//
//   d lambda = -T (Tᵀ W T + S)⁻¹ Tᵀ D d,        d wrench = -(A + Dᵀ T (Tᵀ W T + S)⁻¹ Tᵀ D) d = K d
//
//   bilateral                             in T, S = the law's compliance
//   unilateral with 0 < lambda < limit    in T, S = 0
//   friction, disk, cone that stick       in T, S = 0
//   friction that slips, viscosity c      in T, S = 1/c
//   cone that slips                       in T, across the slip S = |slip|/force, along it S = 1/slope of its law
//   disk that slips                       across the slip in T, S = |slip|/force; along it the force is mu lambda_n
//   all others                            not in T
//
// A: what the needle alone puts against d (inertia of the tick included), a Hessian. Turns do not commute: the torque
// of a base with the torque m on its holder changes by -[m]x/2 times a turn beyond it, so K is symmetric but for that,
// and where a contact slides.
//
// K leaves out terms in proportion to forces: the laws' lines turn with the base, and a needle moved along its path has
// another length beside the last vertex (13 N/m beside 140 N/m of inertia, tests/tick/test_base_stiffness.cpp). Except
// for these, differences of whole ticks agree within 2 %, of free needles and tips in contact within 1e-3.
//
// `lasting` is the wrench without the needle's inertia and damping: sum of Hᵀ lambda and m g about the base.
//
// The model holds until a law leaves its piece: `forward` and `backward` are the nearest such ways along the base's +x
// axis. Beyond, other laws still bear. `forward_yield` and `backward_yield` are the sums of all limits along the
// needle: friction either way, contact and cutting of a tip ahead.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/enums.h"
#include "server/engine/math/factor/block_tridiagonal.h"
#include "server/engine/tick/scratch.h"

namespace acus {

using protocol::ModelLimit;

inline constexpr double kFarthest = 1;     // m, of a limit; beyond it there is none
inline constexpr double kMostYield = 1e6;  // N, likewise: what never opens

struct BaseStiffness {
  Matrix6 stiffness = Matrix6::Zero();               // K: N/m, N/rad, N m/m, N m/rad
  double forward = kFarthest, backward = kFarthest;  // m, in [0, kFarthest]
  ModelLimit forward_limit = ModelLimit::none, backward_limit = ModelLimit::none;
  Vector6 lasting = Vector6::Zero();             // N, N m, world, by the needle on its holder
  double forward_yield = 0, backward_yield = 0;  // N, in [0, kMostYield]
};

class BaseStiffnessSolver {
 public:
  explicit BaseStiffnessSolver(const Model& model);

  // Once after a tick, before compute(). Nothing allocates in either.
  void begin(Scratch& scratch);
  BaseStiffness compute(const Model& scene, const Scratch& scratch, int needle);

 private:
  // An unknown of the laws: the force along one row, or along a combination of the two of a disk.
  struct Unknown {
    int row = 0, other = 0;
    double share = 1, other_share = 0;
    double give = 0;  // S, m/N

    template <class Vector>
    double of(const Vector& rows) const {
      return share * rows[row] + other_share * rows[other];
    }
    void add_to(Eigen::Ref<VectorX> rows, double force) const {
      rows[row] += share * force;
      rows[other] += other_share * force;
    }
  };
  // A contact that slides: mu times the unknown force along its normal acts along the slip.
  struct Slide {
    int normal = 0;  // unknown
    Unknown friction;
  };

  // Of Tᵀ W T + S, lower triangle.
  Eigen::Map<MatrixX> factor() const {
    const auto n = static_cast<Eigen::Index>(unknowns_.size());
    return {room_.data(), n, n};
  }
  void collect(const Rows& rows);
  void collect_cone(const Rows::Cone& cone, const DiskContact& answer);
  void collect_disk(const Rows& rows, int row, int normal);
  void factorize(const Eigen::Ref<const MatrixX>& W);
  void solve(Eigen::Ref<VectorX> x, Eigen::Index slides) const;
  void answer(const Eigen::Ref<const VectorX>& shift, Eigen::Ref<VectorX> forces);
  void put_shifts(const Model& scene, const Scratch& scratch, int needle);
  static void sum_up_yields(const Rows& rows, const Contacts& contacts, int needle, BaseStiffness& result);
  void look_for_limits(const Rows& rows, const Contacts& contacts, const Vector3& axis, BaseStiffness& result);

  std::vector<Unknown> unknowns_;
  std::vector<Slide> slides_;
  std::span<double> room_;   // of factor(), the solver's
  MatrixX slid_;             // unknowns x slides: what a unit of each slide's normal force makes of the unknowns
  MatrixX shifts_, forces_;  // D and d lambda, rows x 6
  VectorX unknown_, moved_, row_shift_, row_force_;
  MatrixX follow_;  // of the needle's free nodes
};

}  // namespace acus
