// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of a tick: pairs of a point on a needle's curve and a point of the tissue's material, a direction n and a
// law. delta = nᵀ(Q - P) for laws on positions, its change during the tick for friction; H_n and H_t follow from the
// pair (paper, eq. 1), with forces +n lambda on the needle and -n lambda on the tissue.
//
// Torsion rows act by couples instead: lambda (N) is the force on the needle's surface, r lambda about n the couple on
// the needle and its opposite on the material, delta = r nᵀ(theta - omega) the slip of the surface in the tick.
// Guide rows act on the needle alone: a guide is held from outside. Rows between two needles act on both, +n lambda on
// the one and -n lambda on the other, and not on the tissue.
//
// A row may stand in series with a spring of its own, the material that the mesh does not resolve: delta is then what
// is left for the law,
//
//   delta = W lambda + delta_free + e lambda,
//
// and the gap of a row on displacements is less by e lambda_n, the spring's stretch under the force lambda_n at the
// start of the tick. The spring stores e lambda²/2, which it returns in full while the law sticks. A nonlinear spring,
// of depth D(lambda), is taken at lambda_n: e = D'(lambda_n), D(lambda_n) - e lambda_n is part of the gap, and `stored`
// is its energy at lambda_n less e lambda_n²/2. In contrast to a law's compliance, which is a foundation under a
// bilateral row, this one is part of W for the solver and goes with any law.
#pragma once

#include <span>
#include <vector>

#include "server/engine/laws/friction_cone.h"
#include "server/engine/laws/solver/constraint_solver.h"
#include "server/engine/models/geometry/material_point.h"
#include "server/engine/models/needle/needle_scratch.h"
#include "server/engine/models/tissue/tissue_scratch.h"

namespace acus {

struct Row {
  int needle = 0;
  CurvePoint on_needle{};
  TissuePoint in_tissue;                   // without a tetrahedron: nothing of the tissue
  Vector3 n = Vector3::Zero();             // unit, world
  double gap = 0;                          // m, delta at q_k, before this iteration's correction
  double radius = 0;                       // r (m), > 0 of torsion rows
  double compliance = 0;                   // e (m/N), >= 0, of the spring in series
  double stored = 0;                       // J, of a nonlinear one
  bool left_out = false;                   // the tissue had no room for it: bears no force
  std::span<const MaterialPoint> patch{};  // not empty: in place of in_tissue; all weights together sum to 1
  int other = -1;                          // the other needle of rows between two,
  const CurvePoint* on_other = nullptr;    // and the point on it, which lives as long as the row

  bool turns() const { return radius > 0; }
  bool acts_on_tissue() const { return !patch.empty() || in_tissue.a.tetrahedron >= 0; }
  bool acts_on(int of_needles) const { return needle == of_needles || other == of_needles; }
};

class Rows {
 public:
  explicit Rows(int capacity);

  void clear();
  int count() const { return static_cast<int>(rows_.size()); }

  // Adds a row with a first guess of its force (N); false if there is no room.
  bool add(const Row& row, const Law& law, double warm_start);

  // Adds a row along a shaft, and with `about` one about it, torsion, whose friction is a cone, with first guesses of
  // their forces. False if there is no room for both.
  bool add_cone(const Row& along, const FrictionCone& friction, double warm_start);
  bool add_cone(const Row& along, const Row& about, const FrictionCone& friction, const Eigen::Vector2d& warm_start);

  // Adds two rows like `row`, of friction in a disk (laws.h), along two directions across the unit vector `normal`.
  // They slip by `slip` (m, world), from which what their spring bore is taken off; `disk` has limit, normal row and
  // cohesion; `before` is the force at the start of the tick (N, world). False if there is no room for both.
  bool add_disk(Row row, const Vector3& normal, const Vector3& slip, const Law& disk, const Vector3& before);

  // Stage 6: W = W_n + W_t and delta_free. False if the corridor has no room for the nodes of all rows: those that it
  // has none for are left out, and have no force.
  bool assemble(std::span<const NeedleModel> models, std::span<NeedleScratch> needles, const TissueSystem& system,
                TissueScratch& tissue);
  // Stage 7. All steps together take not much longer than what a usual tick takes for elimination and one pick, so that
  // the worst tick stays near the usual ones. Where that is too little the best answer is kept, and the next tick goes
  // on from its forces.
  static constexpr double kMostWork = 1;     // of all steps, in factorisations of W,
  static constexpr double kPasses = 8;       // and this many times over its numbers and the curves of the laws
  static constexpr double kLeastWork = 4e6;  // that they may take, however few rows there are: about 0.4 ms
  SolverResult solve(LawMethod method, int max_steps, double tolerance);
  // Forces of the rows that act on a needle, in the order in which they were added, as solve_needle() takes them.
  std::span<const double> needle_forces(int needle);

  const Row& row(int i) const { return rows_[i]; }
  const Law& law(int i) const { return laws_[i]; }
  std::span<const double> lambda() const { return {lambda_.data(), rows_.size()}; }  // N
  std::span<const double> delta() const { return {delta_.data(), rows_.size()}; }    // m
  struct Cone {
    int row;     // along the shaft
    bool turns;  // the next row is about it
    FrictionCone friction;

    int rows() const { return turns ? 2 : 1; }
  };
  // Of the first row of a cone; else nullptr.
  const Cone* find_cone(int row) const;
  // What a cone came to in the last solve.
  DiskContact answer(const Cone& cone) const;
  // Room for square matrices of as many rows as there are, until the next solve().
  std::span<double> room() { return solver_.room(); }
  // W (m/N), of the last assemble().
  Eigen::Map<const MatrixX> compliance() const { return {storage_.data(), count(), count()}; }
  // Of the springs (J), at the forces of the last solve.
  double elastic_energy() const;
  Vector3 force(int i) const { return lambda_[i] * rows_[i].n; }  // on the needle, N

 private:
  bool fits(int more, int more_others) const { return solver_.fits(count() + more, others_ + more_others); }
  void leave_out(int i);
  void leave_out_halves();
  std::span<const int> places_of(int needle);
  // Packed, so that few rows of many take little room in the caches.
  Eigen::Map<MatrixX> W() { return {storage_.data(), count(), count()}; }

  std::vector<Row> rows_;
  int others_ = 0;  // rows that are not bilateral
  std::vector<Law> laws_;
  std::vector<Cone> cones_;
  std::vector<int> places_;  // of the rows that act on one needle
  std::vector<double> lambda_, delta_, delta_free_, needle_lambda_;
  VectorX storage_;  // of W()
  ConstraintSolver solver_;
};

}  // namespace acus
