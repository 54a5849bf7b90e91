// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/laws/rows.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/partial_cholesky.h"
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
  cones_.reserve(n / 2);
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
}

bool Rows::add(const Row& row, const Law& law, double warm_start) {
  assert(row.needle >= 0 && row.compliance >= 0 && law.limit >= 0);
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
    const int needle_row = add_needle_row(r.on_needle.beam, needle_force(needle.shape(), r), needle);
    delta_free_[i] = r.gap + free_displacement(models[r.needle], needle, needle_row);
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

bool Rows::add_cone(const Row& along, const Row& about, const FrictionCone& cone, const Eigen::Vector2d& warm_start) {
  assert(about.role == RowRole::torsion && along.needle == about.needle);
  if (count() + 2 > capacity_) return false;
  cones_.push_back({.row = count(), .cone = cone, .contact = {}});
  return add(along, {LawKind::friction}, warm_start[0]) && add(about, {LawKind::friction}, warm_start[1]);
}

template <class LawsOf>
void Rows::set_cone_laws(LawsOf laws_of) {
  for (const Cone& cone : cones_) {
    const auto [first, second] = laws_of(cone);
    laws_[cone.row] = first;
    laws_[cone.row + 1] = second;
  }
}

// The next solution of a call that has done so much `before`.
SolverResult Rows::solve_laws(LawMethod method, int max_steps, double tolerance, const SolverResult& before) {
  const std::size_t n = rows_.size();
  const int used = before.sweeps + before.steps.picks + before.steps.iterations;
  SolverResult result = solver_.solve(method, W(), laws_, {delta_free_.data(), n}, max_steps - used, tolerance,
                                      {lambda_.data(), n}, {delta_.data(), n});
  result.steps += before.steps;
  result.sweeps += before.sweeps;
  result.fell_back = result.fell_back || before.fell_back;
  return result;
}

SolverResult Rows::solve(LawMethod method, int max_steps, double tolerance) {
  if (cones_.empty()) return solve_laws(method, max_steps, tolerance, {});
  const std::size_t n = rows_.size();
  update_displacements({W(), laws_, {delta_free_.data(), n}, {}}, {{lambda_.data(), n}, {delta_.data(), n}});
  double violation = look_at_cones();
  SolverResult result;
  for (int round = 0; round < kConeRounds && (round == 0 || violation > tolerance) && !result.capped; ++round) {
    set_cone_laws([](const Cone& cone) { return laws_of_rows(cone.cone, cone.contact); });
    result = solve_laws(method, max_steps, tolerance, result);
    violation = look_at_cones();
  }
  if (violation > tolerance && !result.capped) {
    set_cone_laws([](const Cone& cone) { return laws_of_disk(cone.cone); });
    const SolverResult rounds = result;
    result = solve_laws(LawMethod::gauss_seidel, max_steps, tolerance, result);
    result.sweeps = rounds.sweeps;  // those over disks belong to either method, as the first ones of direct do
    result.fell_back = rounds.fell_back;
    violation = look_at_cones();
  }
  result.method = result.fell_back ? LawMethod::gauss_seidel : method;
  set_cone_laws([](const Cone& cone) { return laws_of_rows(cone.cone, cone.contact, 1); });
  if (!(violation <= result.residual)) result.residual = violation;
  result.converged = result.converged && violation <= tolerance;
  return result;
}

double Rows::look_at_cones() {
  double most = 0;
  const auto W = compliance();
  for (Cone& cone : cones_) {
    const int i = cone.row;
    const Eigen::Matrix2d block = W.block<2, 2>(i, i);
    const Eigen::Vector2d force(lambda_[i], lambda_[i + 1]), delta(delta_[i], delta_[i + 1]);
    cone.contact = disk_contact(cone.cone.threshold, cone.cone.viscosity, block, delta - block * force);
    const double violation = (cone.contact.force - force).norm();
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
    if (rows_[i].needle == needle) places_[count++] = static_cast<int>(i);
  return {places_.data(), count};
}

std::span<const double> Rows::needle_forces(int needle) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i)
    if (rows_[i].needle == needle) needle_lambda_[count++] = lambda_[i];
  return {needle_lambda_.data(), count};
}

double Rows::elastic_energy() const {
  double energy = 0;
  for (int i = 0; i < count(); ++i)
    energy += rows_[i].stored + (laws_[i].compliance + rows_[i].compliance) * lambda_[i] * lambda_[i] / 2;
  return energy;
}

}  // namespace acus
