// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/rows.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "server/engine/math/factor/partial_cholesky.h"
#include "server/engine/math/rotation.h"
#include "server/engine/models/needle/needle_rows.h"
#include "server/engine/models/tissue/tissue_row_forces.h"

namespace acus {

namespace {

// Below this compliance (m/N) a row has nothing that gives: a rigid needle in fixed material.
constexpr double kLeastCompliance = 1e-9;

// Room for the solver's matrices: of all rows, and of those that are not bilateral. Along a path that is half of them.
std::size_t room_of(int capacity) {
  constexpr double kOthers = 0.6;
  constexpr int kFew = 200;  // as many may all be others
  const int others = std::max(std::min(capacity, kFew), static_cast<int>(kOthers * capacity));
  return ConstraintSolver::numbers(capacity) + ConstraintSolver::numbers(others);
}

Vector12 needle_force(const NeedleShape& shape, const Row& row) {
  return row.turns() ? curve_torque(row.on_needle, row.radius * row.n) : curve_force(shape, row.on_needle, row.n);
}

// Returns H dq_free (m).
double add_to_needle(const NeedleModel& model, int beam, const Vector12& force, NeedleScratch& needle) {
  return free_displacement(model, needle, add_needle_row(beam, force, needle));
}

int add_to_tissue(const TissueSystem& system, const Row& row, TissueScratch& tissue) {
  if (row.turns()) return add_tissue_couple(system, row.in_tissue.a.tetrahedron, -row.radius * row.n, tissue);
  if (!row.patch.empty()) return add_tissue_row(system, row.patch, -row.n, tissue);
  if (!row.acts_on_tissue()) return add_empty_tissue_row(tissue);
  return add_tissue_row(system, row.in_tissue, -row.n, tissue);
}

}  // namespace

Rows::Rows(int capacity) : solver_(capacity, room_of(capacity)) {
  const auto n = static_cast<std::size_t>(capacity);
  rows_.reserve(n);
  laws_.reserve(n);
  cones_.reserve(n);
  places_.resize(n);
  lambda_.resize(n);
  delta_.resize(n);
  delta_free_.resize(n);
  needle_lambda_.resize(n);
  storage_.setZero(static_cast<Eigen::Index>(capacity) * capacity);
}

void Rows::clear() {
  rows_.clear();
  laws_.clear();
  cones_.clear();
  others_ = 0;
}

bool Rows::add(const Row& row, const Law& law, double warm_start) {
  assert(row.needle >= 0 && row.other != row.needle && (row.other < 0) == (row.on_other == nullptr));
  assert(row.compliance >= 0 && law.limit >= 0);
  assert(!(std::abs(row.n.squaredNorm() - 1) > 1e-6));
  const int other = law.kind == LawKind::bilateral ? 0 : 1;
  if (!fits(1, other)) return false;
  others_ += other;
  lambda_[rows_.size()] = warm_start;
  rows_.push_back(row);
  laws_.push_back(law);
  return true;
}

bool Rows::assemble(std::span<const NeedleModel> models, std::span<NeedleScratch> needles, const TissueSystem& system,
                    TissueScratch& tissue) {
  assert(models.size() == needles.size());
  for (NeedleScratch& needle : needles) needle.rows.clear();
  tissue.rows->clear();
  const int n = count();
  bool all = true;
  for (int i = 0; i < n; ++i) {
    const Row& r = rows_[i];
    NeedleScratch& needle = needles[r.needle];
    delta_free_[i] = r.gap + add_to_needle(models[r.needle], r.on_needle.beam, needle_force(needle.shape(), r), needle);
    if (r.other >= 0) {
      NeedleScratch& other = needles[r.other];
      const Vector12 force = curve_force(other.shape(), *r.on_other, -r.n);
      delta_free_[i] += add_to_needle(models[r.other], r.on_other->beam, force, other);
    }
    if (add_to_tissue(system, r, tissue) < 0) {
      leave_out(i);
      add_empty_tissue_row(tissue);
      all = false;
    }
    assert(tissue.rows->count() == i + 1);
  }
  if (!all) leave_out_halves();
  auto W = this->W();
  set_tissue_compliance(system, W, delta_free_, tissue);
  for (std::size_t k = 0; k < needles.size(); ++k)
    add_needle_compliances(models[k], places_of(static_cast<int>(k)), W, needles[k]);
  W.diagonal() = W.diagonal().cwiseMax(kLeastCompliance);
  mirror_lower(W);
  for (int i = 0; i < n; ++i) W(i, i) += rows_[i].compliance;
  return all;
}

// The law stays of its kind, bilateral or not, of which the solver's room depends.
void Rows::leave_out(int i) {
  constexpr double kNothing = 1e9;  // m/N, that bears no force
  rows_[i].left_out = true;
  rows_[i].stored = 0;
  if (laws_[i].kind == LawKind::bilateral)
    laws_[i].compliance = kNothing;
  else
    laws_[i] = {LawKind::friction, 0};
}

// Of the two rows of a disk or cone neither is left alone.
void Rows::leave_out_halves() {
  for (int i = 0; i + 1 < count(); ++i) {
    const bool first = laws_[i].kind == LawKind::disk_first, second = laws_[i + 1].kind == LawKind::disk_second;
    if (first && !second) leave_out(i);
    if (second && !first) leave_out(i + 1);
  }
}

bool Rows::add_cone(const Row& along, const FrictionCone& friction, double warm_start) {
  if (!fits(1, 1)) return false;
  cones_.push_back({.row = count(), .turns = false, .friction = friction});
  return add(along, {.kind = LawKind::friction, .cone = &cones_.back().friction}, warm_start);
}

bool Rows::add_cone(const Row& along, const Row& about, const FrictionCone& friction,
                    const Eigen::Vector2d& warm_start) {
  assert(about.turns() && along.needle == about.needle);
  if (!fits(2, 2)) return false;
  cones_.push_back({.row = count(), .turns = true, .friction = friction});
  const auto [first, second] = laws_of_disk(cones_.back().friction);
  return add(along, first, warm_start[0]) && add(about, second, warm_start[1]);
}

bool Rows::add_disk(Row row, const Vector3& normal, const Vector3& slip, const Law& disk, const Vector3& before) {
  if (!fits(2, 2)) return false;
  Vector3 across[2];
  perpendicular_basis(normal, across[0], across[1]);
  for (int k = 0; k < 2; ++k) {
    row.n = across[k];
    row.gap = row.n.dot(slip) - row.compliance * before.dot(row.n);
    Law law = disk;
    law.kind = k == 0 ? LawKind::disk_first : LawKind::disk_second;
    add(row, law, before.dot(row.n));
  }
  return true;
}

SolverResult Rows::solve(LawMethod method, int max_steps, double tolerance) {
  const std::size_t n = rows_.size();
  const double work =
      kMostWork * StepBudget::factorisation(count()) + kPasses * (StepBudget::product(count()) + work_of_curves(laws_));
  const StepBudget budget(max_steps, std::max(kLeastWork, work));
  return solver_.solve(method, W(), laws_, {delta_free_.data(), n}, budget, tolerance, {lambda_.data(), n},
                       {delta_.data(), n});
}

DiskContact Rows::answer(const Cone& cone) const {
  const Eigen::Vector2d slip(delta_[cone.row], cone.turns ? delta_[cone.row + 1] : 0);
  const Eigen::Vector2d force(lambda_[cone.row], cone.turns ? lambda_[cone.row + 1] : 0);
  Eigen::Matrix2d block = compliance()(cone.row, cone.row) * Eigen::Matrix2d::Identity();
  if (cone.turns) block = compliance().block<2, 2>(cone.row, cone.row);
  return cone_contact(cone.friction, block, slip - block * force, slip);
}

const Rows::Cone* Rows::find_cone(int row) const {
  const auto cone = std::ranges::lower_bound(cones_, row, {}, &Cone::row);
  return cone != cones_.end() && cone->row == row && !rows_[row].left_out ? &*cone : nullptr;
}

std::span<const int> Rows::places_of(int needle) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i)
    if (rows_[i].acts_on(needle)) places_[count++] = static_cast<int>(i);
  return {places_.data(), count};
}

std::span<const double> Rows::needle_forces(int needle) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i)
    if (rows_[i].acts_on(needle)) needle_lambda_[count++] = lambda_[i];
  return {needle_lambda_.data(), count};
}

double Rows::elastic_energy() const {
  double energy = 0;
  for (int i = 0; i < count(); ++i)
    energy += rows_[i].stored + (laws_[i].compliance + rows_[i].compliance) * lambda_[i] * lambda_[i] / 2;
  return energy;
}

}  // namespace acus
