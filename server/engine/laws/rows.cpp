// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/rows.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "server/engine/math/partial_cholesky.h"
#include "server/engine/math/rotation.h"
#include "server/engine/models/needle_rows.h"
#include "server/engine/models/tissue_row_forces.h"

namespace acus {

namespace {

// Below this compliance (m/N) a row has nothing that gives: a rigid needle in fixed material.
constexpr double kLeastCompliance = 1e-9;
// Solutions of the laws in which cones are followed, at most.
constexpr int kConeRounds = 8;

Vector12 needle_force(const NeedleShape& shape, const Row& row) {
  return row.role == RowRole::torsion ? curve_torque(row.on_needle, row.radius * row.n)
                                      : curve_force(shape, row.on_needle, row.n);
}

// Returns H dq_free (m).
double add_to_needle(const NeedleModel& model, int beam, const Vector12& force, NeedleScratch& needle) {
  return free_displacement(model, needle, add_needle_row(beam, force, needle));
}

int add_to_tissue(const TissueSystem& system, const Row& row, TissueScratch& tissue) {
  if (row.role == RowRole::torsion)
    return add_tissue_couple(system, row.in_tissue.a.tetrahedron, -row.radius * row.n, tissue);
  if (!row.patch.empty()) return add_tissue_row(system, row.patch, -row.n, tissue);
  if (!acts_on_tissue(row.role)) return add_empty_tissue_row(tissue);
  return add_tissue_row(system, row.in_tissue, -row.n, tissue);
}

}  // namespace

Rows::Rows(int capacity) : capacity_(capacity), solver_(capacity) {
  const auto n = static_cast<std::size_t>(capacity);
  rows_.reserve(n);
  laws_.reserve(n);
  cones_.reserve(n);
  places_.resize(n);
  lambda_.resize(n);
  delta_.resize(n);
  delta_free_.resize(n);
  needle_lambda_.resize(n);
  best_lambda_.resize(n);
  best_delta_.resize(n);
  storage_.setZero(static_cast<Eigen::Index>(capacity) * capacity);
}

void Rows::clear() {
  rows_.clear();
  laws_.clear();
  cones_.clear();
}

bool Rows::add(const Row& row, const Law& law, double warm_start) {
  assert(row.needle >= 0 && row.other != row.needle && (row.other < 0) == (row.on_other == nullptr));
  assert(row.compliance >= 0 && law.limit >= 0);
  assert(!(std::abs(row.n.squaredNorm() - 1) > 1e-6));
  if (full()) return false;
  lambda_[rows_.size()] = warm_start;
  rows_.push_back(row);
  laws_.push_back(law);
  return true;
}

void Rows::assemble(std::span<const NeedleModel> models, std::span<NeedleScratch> needles, const TissueSystem& system,
                    TissueScratch& tissue) {
  assert(models.size() == needles.size());
  for (NeedleScratch& needle : needles) needle.rows.clear();
  tissue.rows->clear();
  const int n = count();
  for (int i = 0; i < n; ++i) {
    const Row& r = rows_[i];
    NeedleScratch& needle = needles[r.needle];
    delta_free_[i] = r.gap + add_to_needle(models[r.needle], r.on_needle.beam, needle_force(needle.shape(), r), needle);
    if (r.other >= 0) {
      NeedleScratch& other = needles[r.other];
      const Vector12 force = curve_force(other.shape(), *r.on_other, -r.n);
      delta_free_[i] += add_to_needle(models[r.other], r.on_other->beam, force, other);
    }
    [[maybe_unused]] const int tissue_row = add_to_tissue(system, r, tissue);
    assert(tissue_row == i);
  }
  auto W = this->W();
  set_tissue_compliance(system, W, delta_free_, tissue);
  for (std::size_t k = 0; k < needles.size(); ++k)
    add_needle_compliances(models[k], places_of(static_cast<int>(k)), W, needles[k]);
  W.diagonal() = W.diagonal().cwiseMax(kLeastCompliance);
  mirror_lower(W);
  for (int i = 0; i < n; ++i) W(i, i) += rows_[i].compliance;
}

bool Rows::add_cone(const Row& along, const FrictionCone& friction, double warm_start) {
  if (full()) return false;
  cones_.push_back({.row = count(), .turns = false, .friction = friction, .answer = {}});
  return add(along, {LawKind::friction}, warm_start);
}

bool Rows::add_cone(const Row& along, const Row& about, const FrictionCone& friction,
                    const Eigen::Vector2d& warm_start) {
  assert(about.role == RowRole::torsion && along.needle == about.needle);
  if (count() + 2 > capacity_) return false;
  cones_.push_back({.row = count(), .turns = true, .friction = friction, .answer = {}});
  return add(along, {LawKind::friction}, warm_start[0]) && add(about, {LawKind::friction}, warm_start[1]);
}

bool Rows::add_disk(Row row, const Vector3& normal, const Vector3& slip, const Law& disk, const Vector3& before) {
  if (count() + 2 > capacity_) return false;
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

template <class LawsOf>
void Rows::set_cone_laws(LawsOf laws_of) {
  for (const Cone& cone : cones_) {
    const ConeLaws laws = laws_of(cone);
    for (int k = 0; k < cone.rows(); ++k) laws_[cone.row + k] = laws[k];
  }
}

void Rows::solve_laws(LawMethod method, StepBudget& budget, double tolerance, SolverResult& result) {
  const std::size_t n = rows_.size();
  const SolverResult before = result;
  result = solver_.solve_again(method, W(), laws_, {delta_free_.data(), n}, budget, tolerance, {lambda_.data(), n},
                               {delta_.data(), n});
  result.steps += before.steps;
  result.sweeps += before.sweeps;
  result.fell_back = result.fell_back || before.fell_back;
}

SolverResult Rows::solve(LawMethod method, int max_steps, double tolerance) {
  const std::size_t n = rows_.size();
  const LawState state{{lambda_.data(), n}, {delta_.data(), n}},
      best{{best_lambda_.data(), n}, {best_delta_.data(), n}};
  if (cones_.empty())
    return solver_.solve(method, W(), laws_, {delta_free_.data(), n}, max_steps, tolerance, state.lambda, state.delta);
  solver_.eliminate(W(), laws_);
  update_displacements({W(), laws_, {delta_free_.data(), n}, {}}, state);
  look_at_cones();
  StepBudget budget(max_steps);
  SolverResult result;
  double off_cones = 0, violation = 0, least = std::numeric_limits<double>::infinity();
  const auto solve_rounds = [&](LawMethod by, auto laws_of) {
    for (int round = 0; round < kConeRounds && !budget.spent(); ++round) {
      set_cone_laws(laws_of);
      solve_laws(by, budget, tolerance, result);
      off_cones = look_at_cones();
      violation = off_cones <= result.residual ? result.residual : off_cones;
      if (!(violation >= least)) least = violation, copy(state, best);
      if (!(off_cones > tolerance)) break;
    }
  };
  solve_rounds(method, [](const Cone& cone) { return laws_of_rows(cone.friction, cone.answer); });
  if (off_cones > tolerance) {
    const SolverResult rounds = result;
    solve_rounds(LawMethod::gauss_seidel, [](const Cone& cone) {
      return cone.turns ? laws_of_disk(cone.friction) : laws_of_rows(cone.friction, cone.answer);
    });
    result.sweeps = rounds.sweeps;  // those over disks belong to either method, as the first ones of direct do
    result.fell_back = rounds.fell_back;
  }
  if (violation > least) {
    copy(best, state);
    violation = least;
    look_at_cones();
  }
  result.method = result.fell_back ? LawMethod::gauss_seidel : method;
  result.residual = violation;
  result.converged = violation <= tolerance;
  return result;
}

double Rows::look_at_cones() {
  double most = 0;
  const auto W = compliance();
  for (Cone& cone : cones_) {
    const int i = cone.row;
    Eigen::Matrix2d block = W(i, i) * Eigen::Matrix2d::Identity();
    Eigen::Vector2d force(lambda_[i], 0), delta(delta_[i], 0);
    if (cone.turns) {
      block = W.block<2, 2>(i, i);
      force[1] = lambda_[i + 1];
      delta[1] = delta_[i + 1];
    }
    cone.answer = cone_contact(cone.friction, block, delta - block * force);
    const double violation = (cone.answer.force - force).norm();
    if (!(violation <= most)) most = violation;
    if (std::isnan(most)) break;
  }
  return most;
}

const Rows::Cone* Rows::find_cone(int row) const {
  const auto cone = std::ranges::lower_bound(cones_, row, {}, &Cone::row);
  return cone != cones_.end() && cone->row == row ? &*cone : nullptr;
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
