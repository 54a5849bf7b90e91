// SPDX-License-Identifier: GPL-3.0-or-later
// The motion of one body for tests: model and scratch together, and what a tick does to them as members.
#pragma once

#include "server/engine/models/needle/needle_base.h"
#include "server/engine/models/needle/needle_linearization.h"
#include "server/engine/models/needle/needle_rows.h"
#include "server/engine/models/needle/needle_step.h"
#include "server/engine/models/needle/rigid_needle.h"
#include "server/engine/models/tissue/tissue_linearization.h"
#include "server/engine/models/tissue/tissue_row_forces.h"
#include "server/engine/models/tissue/tissue_step.h"

namespace acus {

class NeedleMotion {
 public:
  NeedleMotion(const NeedleModel& model, double h, int max_rows) : model_(model), scratch_(model, h, max_rows) {}

  void begin(const NeedleState& state, const Pose& base) { begin(state, base, base); }
  void begin(const NeedleState& state, const Pose& base, const Pose& before) {
    begin_needle(model_, state, base, before, scratch_);
  }
  bool linearize(const NeedleState& state, int held = 0) { return linearize_needle(model_, state, held, scratch_); }
  void clear_rows() { scratch_.rows.clear(); }
  int add_row(int beam, const Vector12& force) { return add_needle_row(beam, force, scratch_); }
  void add_compliances(std::span<const int> places, Eigen::Ref<MatrixX> W) {
    add_needle_compliances(model_, places, W, scratch_);
  }
  double free_displacement(int row) const { return acus::free_displacement(model_, scratch_, row); }
  void solve(std::span<const double> lambda) { solve_needle(model_, lambda, scratch_); }
  double trusted_share(const NeedleState& state) { return trusted_needle_share(model_, state, scratch_); }
  double move(double share) { return move_needle(model_, share, scratch_); }
  double correct(std::span<const double> lambda) {  // all of the step, trusted or not
    solve(lambda);
    return move(1);
  }
  void commit(NeedleState& state) const { commit_needle(scratch_, state); }

  const Vector6& base_reaction() const { return scratch_.reaction; }
  Vector3 inertia_less_weight(const NeedleState& state) const {
    return acus::inertia_less_weight(model_, scratch_, state);
  }
  Eigen::Index free_unknowns() const { return scratch_.dq.size(); }
  void follow_base(Eigen::Ref<MatrixX> dq) const { acus::follow_base(model_, scratch_, dq); }
  Vector6 follow_base(int row, const Eigen::Ref<const MatrixX>& dq) const {
    return acus::follow_base(model_, scratch_, row, dq);
  }
  Matrix6 base_tangent(const Eigen::Ref<const MatrixX>& dq) const { return acus::base_tangent(model_, scratch_, dq); }
  NeedleEnergyChange energy_change(const NeedleState& state) const {
    return acus::energy_change(model_, scratch_, state);
  }
  double largest_strain() const { return acus::largest_strain(model_, scratch_); }
  bool finite() const { return scratch_.finite(); }
  const NeedleShape& shape() const { return scratch_.shape(); }

 private:
  const NeedleModel& model_;
  NeedleScratch scratch_;
};

class TissueMotion {
 public:
  TissueMotion(const TissueSystem& system, int max_rows, int max_nodes)
      : system_(system), scratch_(system, max_rows, max_nodes) {}

  void begin(const TissueState& state) { begin_tissue(system_, state, scratch_); }
  bool linearize(const TissueState& state) { return linearize_tissue(system_, state, scratch_); }
  void clear_rows() { scratch_.rows->clear(); }
  int add_row(const TissuePoint& point, const Vector3& force) {
    return add_tissue_row(system_, point, force, scratch_);
  }
  int add_row(std::span<const MaterialPoint> points, const Vector3& force) {
    return add_tissue_row(system_, points, force, scratch_);
  }
  int add_couple(int tetrahedron, const Vector3& torque) {
    return add_tissue_couple(system_, tetrahedron, torque, scratch_);
  }
  int add_empty_row() { return add_empty_tissue_row(scratch_); }
  void set_compliance(Eigen::Ref<MatrixX> W, std::span<double> delta) {
    set_tissue_compliance(system_, W, delta, scratch_);
  }
  bool prepare(int tetrahedron) { return prepare_tissue(system_, tetrahedron, scratch_); }
  void clear_corridor() { scratch_.rows->corridor().clear(); }
  void solve(std::span<const double> lambda) { solve_tissue(system_, lambda, scratch_); }
  double trusted_share() { return trusted_tissue_share(system_, scratch_); }
  double move(double share) { return move_tissue(system_, share, scratch_); }
  double correct(std::span<const double> lambda) {  // all of the step, trusted or not
    solve(lambda);
    return move(1);
  }
  void commit(TissueState& state) { commit_tissue(system_, scratch_, state); }

  bool finite() const { return scratch_.finite(); }
  bool inverted() const { return scratch_.inverted; }
  const Matrix3X& x() const { return scratch_.x; }
  const TissueBalance& balance() const { return scratch_.balance; }
  Precision precision() const { return scratch_.factor(system_).precision(); }
  int corridor_nodes() const { return scratch_.rows->corridor().capacity(); }
  int corridor_used() const { return scratch_.rows->corridor().used(); }

 private:
  const TissueSystem& system_;
  TissueScratch scratch_;
};

}  // namespace acus
